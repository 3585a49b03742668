"""The hunting paper's rows stand beside what was flown."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

TOOL = Path("tools/hunting_figures.py")


def told(folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run((sys.executable, TOOL, folder), capture_output=True, text=True, check=False)


def test_medians_and_ranges_stand_beside_the_papers_row(tmp_path: Path) -> None:
    rows = [
        {
            "scenario": "hunting-3-free",
            "planner": "hunting",
            "seed": seed,
            "outcome": outcome,
            "collided_with": with_what,
            "duration_s": 100.0 + seed,
            "travel_m": 1000.0 + 10.0 * seed,
            "turning_rad": 20.0,
        }
        for seed, outcome, with_what in ((0, "captured", ""), (1, "captured", ""), (2, "collided", "obstacle"))
    ]
    (tmp_path / "episodes.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
    line = told(tmp_path).stdout.splitlines()[-1]
    for cell in (
        "2 of 3",
        "100 (100 to 101)",
        "1010 (1000 to 1020)",
        "collision (obstacle) 1",
        "table 4: yes, 976.6 m, 44.7 rad",
    ):
        assert cell in line


def test_a_folder_without_episodes_is_named(tmp_path: Path) -> None:
    done = told(tmp_path)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert str(tmp_path) in done.stderr

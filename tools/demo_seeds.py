"""Fly one mission with many seeds, one after the other in real time, and put the outcomes in one table.

    python tools/demo_seeds.py missions/demo_two_pursuers.toml --seeds 0-19 --out runs/demo-seeds.json

A contact is a true clearance to an obstacle at or below zero, or two pursuers closer than 1 m. Exit status 1 unless every run
was a capture without contact.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

SEPARATION_CONTACT_M = 1.0
COLUMNS = (
    ("capture_time_s", "capture s", "{:.1f}"),
    ("min_obstacle_clearance_m", "clearance m", "{:.2f}"),
    ("min_separation_m", "separation m", "{:.2f}"),
    ("min_target_distance_m", "to evader m", "{:.2f}"),
    ("boundary_distance_m", "evader-line m", "{:.1f}"),
    ("setpoint_rate_hz", "setpoints Hz", "{:.1f}"),
    ("setpoint_gap_max_ms", "gap ms", "{:.0f}"),
)


def fly(mission: Path, seed: int) -> dict[str, Any]:
    """The summary of one run, with its seed and exit status."""
    done = subprocess.run(
        [sys.executable, "-m", "flightapp", "sim", str(mission), "--seed", str(seed), "--json"],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        check=False,
    )
    summary: dict[str, Any] = json.loads(done.stdout) if done.stdout else {"outcome": None}
    return {**summary, "seed": seed, "exit_status": done.returncode}


def is_contact(summary: dict[str, Any]) -> bool:
    clearance, separation = summary.get("min_obstacle_clearance_m"), summary.get("min_separation_m")
    return (clearance is not None and clearance <= 0.0) or (separation is not None and separation < SEPARATION_CONTACT_M)


def row(summary: dict[str, Any]) -> str:
    cells = [f"{summary['seed']:>5}", f"{summary['outcome']!s:>9}"]
    for name, heading, form in COLUMNS:
        value = summary.get(name)
        cells.append(("-" if value is None else form.format(value)).rjust(len(heading)))
    return "  ".join([*cells, "CONTACT" if is_contact(summary) else ""])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mission", type=Path)
    parser.add_argument("--seeds", default="0-19", help="FIRST-LAST")
    parser.add_argument("--out", type=Path, help="JSON file for the summaries")
    options = parser.parse_args()
    first, _, last = options.seeds.partition("-")
    print("  ".join([" seed", "  outcome", *(heading for _, heading, _ in COLUMNS)]), flush=True)
    summaries = []
    for seed in range(int(first), int(last or first) + 1):
        summaries.append(fly(options.mission, seed))
        print(row(summaries[-1]), flush=True)
    captured = sum(summary["outcome"] == "captured" for summary in summaries)
    contacts = sum(is_contact(summary) for summary in summaries)
    print(f"{captured} of {len(summaries)} captured, {contacts} with contact")
    if options.out is not None:
        options.out.write_text(json.dumps(summaries, indent=2))
    return 0 if captured == len(summaries) and contacts == 0 else 1


if __name__ == "__main__":
    sys.exit(main())

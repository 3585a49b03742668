"""Fly one mission with many seeds, one after the other in real time, and put the outcomes in one table.

    python tools/demo_seeds.py missions/demo_two_pursuers.toml --seeds 0-19 --out runs/demo-seeds.json
    python tools/demo_seeds.py missions/demo_two_pursuers.toml --seeds 0-19 --sensing camera ideal

With ideal sensing no vehicle has a camera: all know the mission's surveyed obstacles. A contact is a true clearance to an
obstacle at or below zero, or two pursuers closer than 1 m. Exit status 1 unless every run was a capture without contact.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path
from typing import Any

import tomli_w

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


def without_cameras(mission: Path, folder: Path) -> Path:
    """A copy of the mission file in `folder` in which no vehicle has a camera; the files that it names stay where they are."""
    tables = tomllib.loads(mission.read_text())
    beside = mission.resolve().parent
    for vehicle in tables["vehicles"]:
        vehicle["camera"] = False
        strategy = vehicle["strategy"]
        if "parameters_file" in strategy:
            strategy["parameters_file"] = str(beside / strategy["parameters_file"])
    faults = tables.get("simulation", {}).get("faults", {})
    faults.update({name: str(beside / script) for name, script in faults.items()})
    copy = folder / mission.name
    copy.write_text(tomli_w.dumps(tables))
    return copy


def is_contact(summary: dict[str, Any]) -> bool:
    clearance, separation = summary.get("min_obstacle_clearance_m"), summary.get("min_separation_m")
    return (clearance is not None and clearance <= 0.0) or (separation is not None and separation < SEPARATION_CONTACT_M)


def row(summary: dict[str, Any]) -> str:
    cells = [f"{summary['seed']:>5}", f"{summary['sensing']:>7}", f"{summary['outcome']!s:>9}"]
    for name, heading, form in COLUMNS:
        value = summary.get(name)
        cells.append(("-" if value is None else form.format(value)).rjust(len(heading)))
    return "  ".join([*cells, "CONTACT" if is_contact(summary) else ""])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mission", type=Path)
    parser.add_argument("--seeds", default="0-19", help="FIRST-LAST")
    parser.add_argument("--sensing", nargs="+", choices=("camera", "ideal"), default=["camera"], help="each seed with each")
    parser.add_argument("--out", type=Path, help="JSON file for the summaries")
    options = parser.parse_args()
    first, _, last = options.seeds.partition("-")
    print("  ".join([" seed", "sensing", "  outcome", *(heading for _, heading, _ in COLUMNS)]), flush=True)
    summaries = []
    with tempfile.TemporaryDirectory() as folder:
        missions = {"camera": options.mission, "ideal": without_cameras(options.mission, Path(folder))}
        for seed in range(int(first), int(last or first) + 1):
            for sensing in options.sensing:
                summaries.append({**fly(missions[sensing], seed), "sensing": sensing})
                print(row(summaries[-1]), flush=True)
    all_good = True
    for sensing in options.sensing:
        flown = [summary for summary in summaries if summary["sensing"] == sensing]
        captured = sum(summary["outcome"] == "captured" for summary in flown)
        contacts = sum(is_contact(summary) for summary in flown)
        all_good = all_good and captured == len(flown) and contacts == 0
        print(f"{sensing}: {captured} of {len(flown)} captured, {contacts} with contact")
    if options.out is not None:
        options.out.write_text(json.dumps(summaries, indent=2))
    return 0 if all_good else 1


if __name__ == "__main__":
    sys.exit(main())

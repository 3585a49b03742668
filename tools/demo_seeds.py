"""Fly one mission with many seeds and put the outcomes in one table.

    python tools/demo_seeds.py missions/demo_two_pursuers.toml --seeds 0-19 --out runs/demo-seeds.json
    python tools/demo_seeds.py missions/demo_two_pursuers.toml --seeds 0-19 --sensing camera ideal --virtual

In real time one after the other, every vehicle a process of its own. With --virtual on a virtual clock, several at once and
whatever else the machine does: the same application with the mock autopilot and rendered depth pictures, without MAVSDK and
Zenoh. With ideal sensing the pursuers know the obstacles of the mission without a picture. A contact is a true clearance to an
obstacle at or below zero, or two pursuers closer than 1 m. Exit status 1 unless every run was a capture without contact.
"""

from __future__ import annotations

import argparse
import json
import logging
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import tomli_w
from joblib import Parallel, delayed

from flightapp.sim.virtual.figures import Referee
from flightapp.sim.virtual.mission import fly_virtual

SIM_PROFILE = Path("profiles/sim.toml")

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


def fly_on_virtual_clock(mission: Path, seed: int, sensing: str) -> dict[str, Any]:
    """The same from a flight on the virtual clock."""
    logging.getLogger().setLevel(logging.ERROR)
    referee = Referee()
    with tempfile.TemporaryDirectory() as folder:
        rendered = sensing == "camera"
        fleet = fly_virtual(mission, SIM_PROFILE, Path(folder), seed=seed, watch=referee.watch, rendered=rendered)
        return {**referee.figures(fleet).plain(), "seed": seed, "sensing": sensing}


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


def real_flights(mission: Path, seeds: Iterable[int], sensing: list[str]) -> Iterator[dict[str, Any]]:
    """Summaries of flights in real time, one after the other."""
    with tempfile.TemporaryDirectory() as folder:
        missions = {"camera": mission, "ideal": without_cameras(mission, Path(folder))}
        for seed in seeds:
            for kind in sensing:
                yield {**fly(missions[kind], seed), "sensing": kind}


def virtual_flights(mission: Path, seeds: Iterable[int], sensing: list[str]) -> Iterator[dict[str, Any]]:
    """Summaries of flights on the virtual clock, one a core at a time, in order."""
    flights = (delayed(fly_on_virtual_clock)(mission, seed, kind) for seed in seeds for kind in sensing)
    yield from Parallel(n_jobs=-1, return_as="generator")(flights)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mission", type=Path)
    parser.add_argument("--seeds", default="0-19", help="FIRST-LAST")
    parser.add_argument("--sensing", nargs="+", choices=("camera", "ideal"), default=["camera"], help="each seed with each")
    parser.add_argument("--virtual", action="store_true", help="on a virtual clock, on all cores")
    parser.add_argument("--out", type=Path, help="JSON file for the summaries")
    options = parser.parse_args()
    first, _, last = options.seeds.partition("-")
    print("  ".join([" seed", "sensing", "  outcome", *(heading for _, heading, _ in COLUMNS)]), flush=True)
    seeds = range(int(first), int(last or first) + 1)
    summaries = []
    for summary in (virtual_flights if options.virtual else real_flights)(options.mission, seeds, options.sensing):
        summaries.append(summary)
        print(row(summary), flush=True)
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

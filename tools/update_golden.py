"""Holds today's planner and supervisor against the golden recordings in tests/replay/golden, or flies those anew.

    python tools/update_golden.py             # status 1 where something is decided differently
    python tools/update_golden.py --update    # after a change that is meant: fly them on the virtual clock and replace them

The differences that an update settles belong into the commit's message.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from flightapp.replay import Wanted, replay
from flightapp.replay.piece import write_piece
from flightapp.sim.virtual.mission import fly_virtual

ROOT = Path(__file__).resolve().parents[1]
GOLDEN = ROOT / "tests" / "replay" / "golden"
PROFILE = ROOT / "profiles" / "sim.toml"
DEMO = ROOT / "missions" / "demo_two_pursuers.toml"
TREE = ROOT / "tests" / "sim" / "virtual" / "beside_a_tree.toml"
SEED = 1
PIECES = {
    "demo_pursuer": (DEMO, "p1", 10.0),
    "demo_evader": (DEMO, "e1", 6.0),
    "beside_a_tree": (TREE, "p1", 8.0),
}
"""Mission, vehicle, and how many seconds from its first decision on."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--update", action="store_true", help="fly the golden recordings anew and replace them")
    arguments = parser.parse_args()
    if arguments.update:
        _update()
    answer = replay(Wanted(GOLDEN))
    print(answer.text())
    sys.exit(0 if answer.identical else 1)


def _update() -> None:
    GOLDEN.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        for mission in dict.fromkeys(mission for mission, _, _ in PIECES.values()):
            run = Path(folder) / mission.stem
            run.mkdir()
            fly_virtual(mission, PROFILE, run, seed=SEED)
        for name, (mission, vehicle, seconds) in PIECES.items():
            write_piece(Path(folder) / mission.stem / f"{vehicle}.mcap", GOLDEN / f"{name}.mcap", seconds)


if __name__ == "__main__":
    main()

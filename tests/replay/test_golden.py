"""Golden recordings: what planner and supervisor decided when they were flown, they decide today.

After a change of behaviour that is meant: `python tools/update_golden.py --update`, and say in the commit what differs.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from flightapp.replay import Wanted, replay
from flightapp.replay.flight import read_flight

GOLDEN = Path(__file__).with_name("golden")
TOLERANCE = 1e-9
"""m/s, rad, m; 0 on one machine. Another processor's instructions may make something else of the last bits."""
NAMES = ("beside_a_tree", "demo_evader", "demo_pursuer")


@pytest.mark.parametrize("name", NAMES)
def test_a_golden_flight_is_decided_as_it_was_flown(name: str) -> None:
    answer = replay(Wanted(GOLDEN / f"{name}.mcap", tolerance=TOLERANCE))
    assert answer.identical, answer.text()
    [one] = answer.replayed
    assert one.complete
    assert one.skipped == 0
    assert one.decisions > 50


def test_the_golden_flights_have_in_them_what_they_are_kept_for() -> None:
    tree = read_flight(GOLDEN / "beside_a_tree.mcap")
    acting = {guard for tick in tree.ticks if tick.sent is not None for guard, _ in tick.sent.acting}
    assert acting & {"obstacle-stop", "separation", "target-keep-out"}, acting
    assert any(tick.given is not None and tick.given.observation.obstacles.discs.size for tick in tree.ticks)
    pursuer = read_flight(GOLDEN / "demo_pursuer.mcap")
    assert any(tick.given is not None and tick.given.observation.target is not None for tick in pursuer.ticks)
    assert any(tick.given is not None and tick.given.observation.team for tick in pursuer.ticks)
    assert read_flight(GOLDEN / "demo_evader.mcap").vehicle.role == "evader"


def test_the_golden_flights_are_small() -> None:
    assert {path.stem for path in GOLDEN.glob("*.mcap")} == set(NAMES)
    assert sum(path.stat().st_size for path in GOLDEN.glob("*")) < 500_000

"""A team torn apart in the hunt: who has the majority hunts on with a leader, who has not keeps back, and one plan joins them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import pytest

from flightapp.core.errors import InputError
from flightapp.core.types import Decision, Observation
from flightapp.sim.batch.episode import Truth, fly
from flightapp.sim.batch.scenario import load_scenario

SCENARIO = Path("missions/scenarios/hunting-1-partition.toml")
FROM_S, UNTIL_S = 12.0, 36.0
SETTLED_S = 10.0
"""By then the lease of a leader that is cut off has ended, and the majority has one of its own."""


class Watch:
    """Decisions and true places by time."""

    def __init__(self) -> None:
        self.seen: list[tuple[float, list[Decision], Truth]] = []

    def step(self, t_s: float, observations: list[Observation], decisions: list[Decision], truth: Truth) -> None:
        del observations
        self.seen.append((t_s, decisions[:-1], truth))

    def end(self, truth: Truth) -> None: ...

    def during(self, from_s: float, until_s: float) -> list[tuple[list[Decision], Truth]]:
        return [(decisions, truth) for t_s, decisions, truth in self.seen if from_s <= t_s < until_s]


def of(decisions: Sequence[Decision], field: str) -> list[object]:
    return [decision.diagnostics[field] for decision in decisions]


@pytest.mark.parametrize("few", [(0, 1), (3, 4)])
def test_three_hunt_on_with_a_leader_two_trail_and_in_the_end_one_plan_for_five_is_flown(few: tuple[int, int]) -> None:
    vehicles = str([f"p{index + 1}" for index in few])
    torn = f"[{{vehicles = {vehicles}, from_s = {FROM_S}, until_s = {UNTIL_S}}}]"
    watch = Watch()
    result = fly(load_scenario(SCENARIO, {"messages.partitions": torn, "time_limit_s": "46"}), "hunting", 10000, watcher=watch)
    assert result.outcome == "timed_out"
    assert result.min_separation_m > 5.0, "between surfaces, as on the ring"
    many = [index for index in range(5) if index not in few]
    for decisions, truth in watch.during(FROM_S + SETTLED_S, UNTIL_S):
        assert of([decisions[i] for i in many], "plan") == ["leader"] * 3
        assert sorted(map(int, of([decisions[i] for i in many], "slot"))) == [0, 1, 2]  # type: ignore[call-overload]
        for i in few:
            assert decisions[i].diagnostics["flags"] == ["degraded", "no quorum"]
        assert sorted(map(int, of([decisions[i] for i in few], "slot"))) == [-2, -1]  # type: ignore[call-overload]
        first, second = (truth.states[i].position_ned_m for i in few)
        assert math.dist(first, second) > 2.0 * 2.0 + 5.0
    after = [decisions for decisions, _ in watch.during(UNTIL_S + 3.0, 46.0)]
    assert all(of(decisions, "plan") == ["leader"] * 5 for decisions in after)
    assert len({tuple(of(decisions, "slot")) for decisions in after}) == 1, "assigned once"
    assert sorted(of(after[0], "slot")) == [0, 1, 2, 3, 4]  # type: ignore[type-var]
    assert not any(of(after[-1], "flags"))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("torn", "said"),
    [
        ('[{vehicles = ["p6"], from_s = 1.0, until_s = 2.0}]', "'p6' is none of the pursuers; name p1 to p5"),
        ('[{vehicles = ["p1"], from_s = 3.0, until_s = 2.0}]', "until_s = 2.0: must be greater than from_s = 3.0"),
    ],
)
def test_a_partition_that_cannot_be_is_refused_in_one_sentence(torn: str, said: str) -> None:
    with pytest.raises(InputError) as refused:
        load_scenario(SCENARIO, {"messages.partitions": torn})
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)

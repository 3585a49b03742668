"""A team torn apart around the evader: each side encircles with whom it hears, and nobody is touched before or after."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flightapp.core.types import Decision, Observation
from flightapp.planning.encirclement.box import Box
from flightapp.planning.encirclement.parameters import EncirclementParameters
from flightapp.sim.batch.episode import Truth, fly
from flightapp.sim.batch.scenario import load_scenario
from tests.planning.encirclement.arena import CAPTURE

FOREST = Path(__file__).parents[3] / "missions/scenarios/forest.toml"
FROM_S, UNTIL_S, END_S = 2.0, 4.6, 8.0
FEW = ("p1", "p2")


class Watch:
    """Decisions of every period."""

    def __init__(self) -> None:
        self.decisions: list[tuple[float, list[Decision]]] = []

    def step(self, t_s: float, observations: list[Observation], decisions: list[Decision], truth: Truth) -> None:
        del observations, truth
        self.decisions.append((t_s, decisions[:-1]))

    def end(self, truth: Truth) -> None: ...


def test_both_sides_go_on_and_join_again_without_contact() -> None:
    torn = f"[{{vehicles = {list(FEW)}, from_s = {FROM_S}, until_s = {UNTIL_S}}}]"
    watch = Watch()
    result = fly(
        load_scenario(FOREST, {"messages.partitions": torn, "time_limit_s": f"{END_S}"}), "oa-ecbvc", 10003, watcher=watch
    )
    assert result.outcome == "timed_out", "nobody touched anything"
    assert result.min_separation_m > 0.8, "who is unheard is given room: 0.56 m without"
    for t_s, decisions in watch.decisions:
        unheard = ["teammate unheard" in decision.diagnostics["flags"] for decision in decisions]  # type: ignore[operator]
        if FROM_S + 1.1 < t_s < UNTIL_S:
            assert all(unheard)
        elif t_s < FROM_S or t_s > UNTIL_S + 0.2:
            assert not any(unheard)
    assert {decision.mode for decision in watch.decisions[-1][1]} == {"capture"}, "who heard of the encirclement joins it"


def test_boxes_of_different_ages_become_the_same() -> None:
    """Nobody sends the moment of the encirclement: after a partition boxes differ by what the later one has yet to shrink."""
    ring = np.array(((5.0, 0.0), (-4.0, 4.0), (-4.0, -4.0)))
    early, late = (Box(EncirclementParameters.model_validate({"capture": CAPTURE}), 1.0, 0.16) for _ in range(2))
    for tick in range(80):
        t_s = 0.1 * tick
        first = early.half_sizes_m(t_s, 0.1, ring, (0.0, 0.0), 0.0, -1.0, False)
        second = late.half_sizes_m(t_s, 0.1, ring, (0.0, 0.0), 0.0, 1.0, t_s >= 2.0)
        assert 0.0 <= second[0] - first[0] <= 2.0 + 1e-9
    assert first == second

"""The state machine over every state and condition."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import pytest

from flightapp.planning.ac2f import Ac2fParameters
from flightapp.planning.ac2f.stage import Facts, Stage, next_stage

PARAMETERS = Ac2fParameters()
CALM = Facts(
    target_age_s=0.0,
    distance_m=20.0,
    closest_m=20.0,
    oscillating=False,
    captured=False,
    trapped_in=False,
    fine_s=0.1,
    coarse_s=0.1,
    paused=False,
)

CASES = [
    (Stage.HOLD, {}, Stage.COARSE),
    (Stage.SEARCH, {}, Stage.COARSE),
    (Stage.COARSE, {}, Stage.COARSE),
    (Stage.COARSE, {"distance_m": 3.9}, Stage.FINE),
    (Stage.COARSE, {"distance_m": 3.9, "paused": True}, Stage.COARSE),
    (Stage.COARSE, {"distance_m": 3.9, "paused": True, "coarse_s": 1.1}, Stage.FINE),
    (Stage.COARSE, {"oscillating": True}, Stage.FINE),
    (Stage.COARSE, {"oscillating": True, "captured": True}, Stage.COARSE),
    (Stage.FINE, {"distance_m": 4.2}, Stage.FINE),
    (Stage.FINE, {"distance_m": 4.6}, Stage.COARSE),
    (Stage.FINE, {"distance_m": 20.0, "trapped_in": True}, Stage.FINE),
    (Stage.FINE, {"distance_m": 3.0, "fine_s": 3.0}, Stage.COARSE),
    (Stage.FINE, {"distance_m": 20.0, "trapped_in": True, "fine_s": 3.0}, Stage.COARSE),
    (Stage.FINE, {"distance_m": 0.5, "closest_m": 0.39}, Stage.TRACKING),
    (Stage.FINE, {"distance_m": 3.0, "closest_m": 0.41}, Stage.FINE),
    (Stage.TRACKING, {"distance_m": 1.3}, Stage.TRACKING),
    (Stage.TRACKING, {"distance_m": 1.5}, Stage.FINE),
    (Stage.TRACKING, {"distance_m": 9.0}, Stage.COARSE),
    (Stage.TRACKING, {"distance_m": 9.0, "captured": True}, Stage.TRACKING),
]


@pytest.mark.parametrize(("stage", "changes", "expected"), CASES)
def test_transition(stage: Stage, changes: dict[str, object], expected: Stage) -> None:
    found, reason = next_stage(stage, replace(CALM, **changes), PARAMETERS)  # type: ignore[arg-type]
    assert found is expected
    assert bool(reason) == (found is not stage)


@pytest.mark.parametrize("stage", list(Stage))
@pytest.mark.parametrize(("age_s", "expected"), [(None, Stage.HOLD), (2.1, Stage.SEARCH), (10.1, Stage.HOLD)])
def test_a_missing_target_comes_first(stage: Stage, age_s: float | None, expected: Stage) -> None:
    found, reason = next_stage(stage, replace(CALM, target_age_s=age_s, oscillating=True), PARAMETERS)
    assert found is expected
    assert bool(reason) == (found is not stage)


def test_fine_is_left_in_time_whatever_else_holds() -> None:
    for distance, closest, oscillating, captured, trapped in itertools.product(
        (0.3, 3.0, 20.0), (0.3, 3.0), (True, False), (True, False), (True, False)
    ):
        facts = replace(CALM, distance_m=distance, closest_m=closest, oscillating=oscillating, captured=captured)
        assert next_stage(Stage.FINE, replace(facts, trapped_in=trapped, fine_s=3.0), PARAMETERS)[0] is not Stage.FINE


def test_a_commanded_hover_never_enters_fine_by_oscillation() -> None:
    for stage in (Stage.HOLD, Stage.SEARCH, Stage.TRACKING):
        facts = replace(CALM, oscillating=True, distance_m=math.inf if stage is not Stage.TRACKING else 1.0)
        assert next_stage(stage, facts, PARAMETERS)[0] is not Stage.FINE

"""The state machine over every state and condition."""

from __future__ import annotations

import itertools
import math
from dataclasses import astuple, dataclass, replace

import numpy as np
import pytest

from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.records import parameter_record
from flightapp.planning.ac2f.stage import COARSE, FINE, HOLD, SEARCH, STAGES, TRACKING, next_stage, sentences
from tests.planning.closed_loop import limits

PARAMETERS = Ac2fParameters()
EITHER = (True, False)


@dataclass(frozen=True)
class Facts:
    """What `next_stage` takes, in its order."""

    target_age_s: float = 0.0
    distance_m: float = 20.0
    closest_m: float = 20.0
    since_s: float = 0.1
    oscillating: bool = False
    captured: bool = False
    trapped_in: bool = False
    paused: bool = False


CALM = Facts()


def after(stage: int, facts: Facts, parameters: Ac2fParameters = PARAMETERS) -> tuple[int, str]:
    """The next stage and the reason in words."""
    found, reason = next_stage(parameter_record(parameters, limits()), stage, *astuple(facts))
    return found, sentences(parameters)[reason]


CASES = [
    (HOLD, {}, COARSE),
    (SEARCH, {}, COARSE),
    (COARSE, {}, COARSE),
    (COARSE, {"distance_m": 3.9}, FINE),
    (COARSE, {"distance_m": 3.9, "paused": True}, COARSE),
    (COARSE, {"distance_m": 3.9, "paused": True, "since_s": 1.1}, FINE),
    (COARSE, {"oscillating": True}, FINE),
    (COARSE, {"oscillating": True, "captured": True}, COARSE),
    (FINE, {"distance_m": 4.2}, FINE),
    (FINE, {"distance_m": 4.6}, COARSE),
    (FINE, {"distance_m": 20.0, "trapped_in": True}, FINE),
    (FINE, {"distance_m": 3.0, "since_s": 3.0}, COARSE),
    (FINE, {"distance_m": 20.0, "trapped_in": True, "since_s": 3.0}, COARSE),
    (FINE, {"distance_m": 0.5, "closest_m": 0.39}, TRACKING),
    (FINE, {"distance_m": 3.0, "closest_m": 0.41}, FINE),
    (TRACKING, {"distance_m": 1.3}, TRACKING),
    (TRACKING, {"distance_m": 1.5}, FINE),
    (TRACKING, {"distance_m": 9.0}, COARSE),
    (TRACKING, {"distance_m": 9.0, "captured": True}, TRACKING),
]


@pytest.mark.parametrize(("stage", "changes", "expected"), CASES)
def test_transition(stage: int, changes: dict[str, object], expected: int) -> None:
    found, reason = after(stage, replace(CALM, **changes))  # type: ignore[arg-type]
    assert found == expected
    assert bool(reason) == (found != stage)


@pytest.mark.parametrize("stage", range(len(STAGES)))
@pytest.mark.parametrize(("age_s", "expected"), [(math.nan, HOLD), (2.1, SEARCH), (10.1, HOLD)])
def test_a_missing_target_comes_first(stage: int, age_s: float, expected: int) -> None:
    found, reason = after(stage, replace(CALM, target_age_s=age_s, oscillating=True))
    assert found == expected
    assert bool(reason) == (found != stage)


def test_fine_is_left_in_time_whatever_else_holds() -> None:
    for distance, closest, oscillating, captured, trapped in itertools.product(
        (0.3, 3.0, 20.0), (0.3, 3.0), (True, False), (True, False), (True, False)
    ):
        facts = replace(CALM, distance_m=distance, closest_m=closest, oscillating=oscillating, captured=captured)
        assert after(FINE, replace(facts, trapped_in=trapped, since_s=3.0))[0] != FINE


def test_a_commanded_hover_never_enters_fine_by_oscillation() -> None:
    for stage in (HOLD, SEARCH, TRACKING):
        facts = replace(CALM, oscillating=True, distance_m=math.inf if stage is not TRACKING else 1.0)
        assert after(stage, facts)[0] != FINE


def every_fact() -> list[Facts]:
    distances = ((0.3, 0.3), (3.0, 0.3), (3.0, 3.0), (20.0, 20.0))
    return [
        Facts(0.0, distance, closest, since_s, *truths)
        for distance, closest in distances
        for since_s in (0.1, 5.0)
        for truths in itertools.product(EITHER, repeat=4)
    ]


def test_one_stage_only_is_never_left_for_the_other() -> None:
    coarse_only, fine_only = Ac2fParameters(stages="coarse"), Ac2fParameters(stages="fine")
    for stage, facts in itertools.product(range(len(STAGES)), every_fact()):
        if stage != FINE:
            assert after(stage, facts, coarse_only)[0] in (COARSE, TRACKING)
        assert after(stage, facts, fine_only)[0] == FINE
    assert after(COARSE, replace(CALM, distance_m=0.3, closest_m=0.3), coarse_only)[0] == TRACKING
    assert after(FINE, replace(CALM, target_age_s=3.0), fine_only)[0] == SEARCH


def test_every_change_has_its_reason_and_nothing_else_has() -> None:
    reasons = set()
    for stage, facts in itertools.product(range(len(STAGES)), every_fact()):
        found, reason = after(stage, facts)
        assert bool(reason) == (found != stage)
        reasons.add(reason)
    assert "4 m" in " ".join(reasons)
    assert np.all([reason.format(closest_m=0.39) for reason in reasons if reason])

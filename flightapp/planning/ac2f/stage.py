"""The state machine of section 6: pure transitions on named facts."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from flightapp.planning.ac2f.parameters import Ac2fParameters


class Stage(StrEnum):
    HOLD = "hold"
    SEARCH = "search"
    COARSE = "coarse"
    FINE = "fine"
    TRACKING = "tracking"


@dataclass(frozen=True, slots=True)
class Facts:
    """What decides about the stage in one step.

    target_age_s: None if no target was ever seen. closest_m: closest approach to the evader since the last step.
    trapped_in: the fine stage was entered because of an oscillation. fine_s, coarse_s: time since the stage was entered.
    """

    target_age_s: float | None
    distance_m: float
    closest_m: float
    oscillating: bool
    captured: bool
    trapped_in: bool
    fine_s: float
    coarse_s: float
    paused: bool


def next_stage(stage: Stage, facts: Facts, parameters: Ac2fParameters) -> tuple[Stage, str]:
    """The stage of this step and the reason of the change, empty without one."""
    if facts.target_age_s is None:
        return _changed(stage, Stage.HOLD, "no target was seen yet")
    if facts.target_age_s > parameters.target_lost_s:
        return _changed(stage, Stage.HOLD, f"target not seen for {parameters.target_lost_s:g} s")
    if facts.target_age_s > parameters.target_stale_s:
        return _changed(stage, Stage.SEARCH, f"target not seen for {parameters.target_stale_s:g} s")
    if stage in (Stage.HOLD, Stage.SEARCH):
        return Stage.COARSE, "target is seen"
    if stage is Stage.COARSE:
        return _from_coarse(facts, parameters)
    if stage is Stage.FINE:
        return _from_fine(facts, parameters)
    return _from_tracking(facts, parameters)


def _changed(stage: Stage, wanted: Stage, reason: str) -> tuple[Stage, str]:
    return wanted, "" if stage is wanted else reason


def _from_coarse(facts: Facts, parameters: Ac2fParameters) -> tuple[Stage, str]:
    if facts.distance_m < parameters.fine_trigger_m and not (facts.paused and facts.coarse_s < parameters.fine_pause_s):
        return Stage.FINE, f"evader within {parameters.fine_trigger_m:g} m"
    if facts.oscillating and not facts.captured:
        return Stage.FINE, "own motion is confined"
    return Stage.COARSE, ""


def _from_fine(facts: Facts, parameters: Ac2fParameters) -> tuple[Stage, str]:
    if facts.closest_m <= parameters.capture.radius_m and facts.distance_m <= parameters.capture.zone_m:
        return Stage.TRACKING, f"capture condition met at {facts.closest_m:.2f} m"
    if facts.fine_s >= parameters.fine_time_max_s:
        return Stage.COARSE, f"{parameters.fine_time_max_s:g} s in the fine stage without capture"
    if not facts.trapped_in and facts.distance_m > parameters.fine_trigger_m + parameters.fine_hysteresis_m:
        return Stage.COARSE, "evader is out of the fine distance"
    return Stage.FINE, ""


def _from_tracking(facts: Facts, parameters: Ac2fParameters) -> tuple[Stage, str]:
    if facts.captured or facts.distance_m <= parameters.capture.zone_m:
        return Stage.TRACKING, ""
    if facts.distance_m < parameters.fine_trigger_m:
        return Stage.FINE, "evader left the capture zone"
    return Stage.COARSE, "evader left the capture zone and the fine distance"

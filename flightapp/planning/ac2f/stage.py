"""The state machine of section 6: pure transitions on named facts."""

from __future__ import annotations

import math

import numba

from flightapp.core.compiled import compiled
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.records import NUMBER, PARAMETERS_TYPE, TRUTH, WHOLE, Record, code_of

HOLD, SEARCH, COARSE, FINE, TRACKING = range(5)
STAGES = ("hold", "search", "coarse", "fine", "tracking")
"""Names of the stages, as modes of decisions and recordings."""

BOTH = code_of(Ac2fParameters, "stages", "both")
COARSE_ONLY = code_of(Ac2fParameters, "stages", "coarse")
FINE_ONLY = code_of(Ac2fParameters, "stages", "fine")

(NO_CHANGE, NEVER_SEEN, LOST, STALE, SEEN, NEAR, CONFINED, MET, EXPIRED, FAR, LEFT_ZONE, LEFT_ALL) = range(12)
"""Why a stage was entered: index in `sentences`."""


def sentences(parameters: Ac2fParameters) -> tuple[str, ...]:
    """The reasons in words; the place {closest_m} is filled where it occurs."""
    return (
        "",
        "no target was seen yet",
        f"target not seen for {parameters.target_lost_s:g} s",
        f"target not seen for {parameters.target_stale_s:g} s",
        "target is seen",
        f"evader within {parameters.fine_trigger_m:g} m",
        "own motion is confined",
        "capture condition met at {closest_m:.2f} m",
        f"{parameters.fine_time_max_s:g} s in the fine stage without capture",
        "evader is out of the fine distance",
        "evader left the capture zone",
        "evader left the capture zone and the fine distance",
    )


CHANGE_TYPE = numba.types.UniTuple(WHOLE, 2)  # type: ignore[no-untyped-call]


@compiled(CHANGE_TYPE(WHOLE, WHOLE, WHOLE))
def _changed(stage: int, wanted: int, reason: int) -> tuple[int, int]:
    return wanted, NO_CHANGE if stage == wanted else reason


@compiled(CHANGE_TYPE(PARAMETERS_TYPE, WHOLE, *(NUMBER,) * 4, *(TRUTH,) * 4))
def next_stage(
    parameters: Record,
    stage: int,
    target_age_s: float,
    distance_m: float,
    closest_m: float,
    since_s: float,
    oscillating: bool,
    captured: bool,
    trapped_in: bool,
    paused: bool,
) -> tuple[int, int]:
    """The stage of this step and why it was entered.

    target_age_s: NaN if no target was ever seen. distance_m, closest_m: to the evader now, and at the closest since the last
    step. since_s: how long the stage lasts. trapped_in: the fine stage was entered because of an oscillation. paused: it ended
    by its time limit within the fine distance.
    """
    p = parameters[0]
    if math.isnan(target_age_s):
        return _changed(stage, HOLD, NEVER_SEEN)
    if target_age_s > p.target_lost_s:
        return _changed(stage, HOLD, LOST)
    if target_age_s > p.target_stale_s:
        return _changed(stage, SEARCH, STALE)
    if p.stages == FINE_ONLY:
        return _changed(stage, FINE, SEEN)
    if stage in (HOLD, SEARCH):
        return COARSE, SEEN
    if stage == TRACKING:
        if captured or distance_m <= p.zone_m:
            return TRACKING, NO_CHANGE
        if distance_m < p.fine_trigger_m and p.stages == BOTH:
            return FINE, LEFT_ZONE
        return COARSE, LEFT_ALL
    if (stage == FINE or p.stages == COARSE_ONLY) and closest_m <= p.capture_radius_m and distance_m <= p.zone_m:
        return TRACKING, MET
    if stage == FINE:
        if since_s >= p.fine_time_max_s:
            return COARSE, EXPIRED
        if not trapped_in and distance_m > p.fine_trigger_m + p.fine_hysteresis_m:
            return COARSE, FAR
    elif p.stages == BOTH:
        if distance_m < p.fine_trigger_m and not (paused and since_s < p.fine_pause_s):
            return FINE, NEAR
        if oscillating and not captured:
            return FINE, CONFINED
    return stage, NO_CHANGE

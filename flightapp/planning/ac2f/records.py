"""Everything a compiled step reads or writes by name: parameters, the planner's memory, and the values of one step.

Each is a NumPy record in an array of length 1, so that kernels say `parameters.fine_trigger_m` instead of taking forty
arguments. Positions and velocities are planar (north, east) in the mission frame, suffixes _n and _e.
"""

from __future__ import annotations

import dataclasses
from typing import Literal, get_args, get_origin

import numba
import numpy as np
from numpy.typing import NDArray

from flightapp.core.types import Limits
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.volume.parameters import VolumeParameters
from flightapp.planning.capture import CaptureRule

Record = NDArray[np.void]


def code_of(model: type[Ac2fParameters] | type[CaptureRule], field: str, word: str) -> int:
    """The number that stands in a record for `word` as the choice `field` of `model`."""
    return get_args(model.model_fields[field].annotation).index(word)


def _plain_fields(model: type[Ac2fParameters] | type[CaptureRule], prefix: str = "") -> list[tuple[str, str]]:
    """(name, "f8" or "i8") of the numbers of a parameter model; a choice of words becomes the index of the word."""
    fields = []
    for name, info in model.model_fields.items():
        if info.annotation in (CaptureRule, VolumeParameters):
            continue
        whole = info.annotation in (int, bool) or get_origin(info.annotation) is Literal
        fields.append((prefix + name, "i8" if whole else "f8"))
    return fields


DERIVED = (
    "inflation_m",  # of obstacle discs
    "braking_m_s2",  # what braking before obstacles may assume
    "slot_braking_m_s2",  # what the approach to a slot plans with
    "fine_trigger_m",
    "zone_m",
    "slot_radius_m",
    "evader_distance_m",  # smallest distance to keep from the evader; 0 where the capture needs contact
)
LIMITS = tuple(field.name for field in dataclasses.fields(Limits) if field.name != "sink_rate_max_m_s")
"""Of the vehicle, as the planar kernels have them."""
PARAMETER_FIELDS = (
    _plain_fields(Ac2fParameters)
    + _plain_fields(CaptureRule, "capture_")
    + [(name, "f8") for name in LIMITS]
    + [(name, "f8") for name in DERIVED]
    + [("oscillation_samples", "i8")]
)

MEMORY_FIELDS = [
    ("stage", "i8"),  # index in stage.STAGES
    ("stage_since_s", "f8"),
    ("trapped", "i8"),  # the memory penalty is on, since the vehicle was at trapped_n, trapped_e
    ("trapped_n", "f8"),
    ("trapped_e", "f8"),
    ("trapped_in", "i8"),  # the fine stage was entered because of an oscillation
    ("paused", "i8"),  # the fine stage ended by its time limit within the fine distance
    ("boundary_lost", "i8"),
    ("has_command", "i8"),
    ("command_n", "f8"),
    ("command_e", "f8"),
    ("turn_rad_s", "f8"),
    ("yaw_rad", "f8"),
    ("has_before", "i8"),
    ("before_own_n", "f8"),
    ("before_own_e", "f8"),
    ("before_evader_n", "f8"),
    ("before_evader_e", "f8"),
    ("has_seen", "i8"),  # the target was seen at seen_s, or last predicted there
    ("seen_s", "f8"),
    ("seen_n", "f8"),
    ("seen_e", "f8"),
    ("dwell_since_s", "f8"),  # NaN: the encirclement does not hold
    ("captured", "i8"),
    ("history_count", "i8"),
    ("history_next_s", "f8"),
    ("trail_count", "i8"),
    ("trail_next_s", "f8"),
    ("disc_count", "i8"),  # rows of the disc memory
    ("discs_t_s", "f8"),  # time of the last observation in it
    ("guided", "i8"),
    ("guided_since_s", "f8"),
    ("guidance_next_s", "f8"),  # no search for a way before
    ("guidance_free_s", "f8"),  # since when the straight way is free; inf: it is not
    ("way_count", "i8"),  # corners of the way that is followed
    ("way_next", "i8"),  # the corner that is flown to: the guidance point
]

VIEW_FIELDS = [
    ("t_s", "f8"),
    ("own_n", "f8"),
    ("own_e", "f8"),
    ("own_yaw_rad", "f8"),
    ("base_n", "f8"),  # velocity from which the window opens
    ("base_e", "f8"),
    ("ahead_n", "f8"),  # where the lag of the velocity loop puts the vehicle
    ("ahead_e", "f8"),
    ("team_count", "i8"),  # teammates whose state is fresh
    ("team_complete", "i8"),  # all of them are
    ("target_known", "i8"),
    ("target_n", "f8"),
    ("target_e", "f8"),
    ("target_vn", "f8"),
    ("target_ve", "f8"),
    ("target_age_s", "f8"),
    ("distance_m", "f8"),  # to the target; inf where unknown
    ("closest_m", "f8"),  # closest approach to the target since the last step; inf where unknown
    ("obstacle_count", "i8"),  # rows of the scene that are obstacles
    ("scene_count", "i8"),  # all rows: obstacles, then vehicles
    ("depth_m", "f8"),  # how deep the vehicle is inside the worst inflation
    ("clearance_m", "f8"),  # to the nearest inflated edge, at most the obstacle range
    ("surrounded", "i8"),
    ("assigned", "i8"),  # the team's plan gives the slot
    ("assigned_rad", "f8"),
]

INTENT_FIELDS = [
    ("known", "i8"),  # 0: no intent in this step (hold, search)
    ("goal_n", "f8"),
    ("goal_e", "f8"),
    ("velocity_n", "f8"),
    ("velocity_e", "f8"),
    ("eta_s", "f8"),
    ("contested", "i8"),
    ("point_n", "f8"),  # the game point
    ("point_e", "f8"),
    ("boundary_m", "f8"),  # its distance from the boundary
]

ACTION_FIELDS = [
    ("velocity_n", "f8"),
    ("velocity_e", "f8"),
    ("yaw_rad", "f8"),
    ("has_goal", "i8"),
    ("goal_n", "f8"),
    ("goal_e", "f8"),
    ("searched", "i8"),  # the dynamic window was searched: the rest is valid
    ("best", "i8"),  # index of the chosen candidate; -1: none is admissible
    ("heading", "f8"),  # raw scores of the best
    ("clearance", "f8"),
    ("velocity", "f8"),
    ("memory", "f8"),
    ("weight_heading", "f8"),
    ("weight_clearance", "f8"),
    ("weight_velocity", "f8"),
    ("weight_memory", "f8"),
    ("collisions", "i8"),  # candidates rejected on their arc
    ("brakings", "i8"),  # candidates rejected on their braking arc
]

REPORT_FIELDS = [
    ("velocity_n", "f8"),
    ("velocity_e", "f8"),
    ("yaw_rad", "f8"),
    ("stage", "i8"),
    ("reason", "i8"),  # index in stage.sentences
    ("has_goal", "?"),
    ("goal_n", "f8"),
    ("goal_e", "f8"),
    ("target_known", "?"),
    ("distance_m", "f8"),
    ("closest_m", "f8"),
    ("clearance_m", "f8"),
    ("surrounded", "?"),
    ("captured", "?"),
    ("memory_weight", "f8"),
    ("searched", "?"),  # the dynamic window was searched
    ("guided", "?"),  # the goal is a guidance point
    ("pursuer_count", "i8"),  # of the game; 0: it was not solved in this step, and the rest is not valid
    ("eta_s", "f8"),
    ("contested", "?"),
    ("point_n", "f8"),
    ("point_e", "f8"),
]

PARAMETERS = np.dtype(PARAMETER_FIELDS, align=True)
MEMORY = np.dtype(MEMORY_FIELDS, align=True)
VIEW = np.dtype(VIEW_FIELDS, align=True)
INTENT = np.dtype(INTENT_FIELDS, align=True)
ACTION = np.dtype(ACTION_FIELDS, align=True)
REPORT = np.dtype(REPORT_FIELDS, align=True)


def _passed(dtype: np.dtype[np.void]) -> numba.types.Type:
    return numba.types.Array(numba.from_dtype(dtype), 1, "C")


NUMBER = numba.float64
WHOLE = numba.int64
TRUTH = numba.boolean
VECTOR = numba.float64[::1]
ROWS = numba.float64[:, ::1]
PARAMETERS_TYPE = _passed(PARAMETERS)
MEMORY_TYPE = _passed(MEMORY)
VIEW_TYPE = _passed(VIEW)
INTENT_TYPE = _passed(INTENT)
ACTION_TYPE = _passed(ACTION)
REPORT_TYPE = _passed(REPORT)


def parameter_record(parameters: Ac2fParameters, limits: Limits) -> Record:
    """`parameters` and `limits` with what follows from both, as one record (1,)."""
    record = np.zeros(1, PARAMETERS)
    _fill(record, parameters)
    _fill(record, parameters.capture, "capture_")
    for name in LIMITS:
        record[name] = getattr(limits, name)
    rule = parameters.capture
    record["inflation_m"] = max(parameters.rejection_radius_m, limits.body_radius_m + limits.safety_margin_m)
    record["braking_m_s2"] = limits.acceleration_max_m_s2 * parameters.braking_share
    record["slot_braking_m_s2"] = limits.acceleration_max_m_s2 * parameters.slot_braking_share
    record["fine_trigger_m"] = parameters.fine_trigger_m
    record["zone_m"] = rule.zone_m
    record["slot_radius_m"] = rule.slot_radius_m
    keep_out = parameters.evader_keep_out_m
    record["evader_distance_m"] = keep_out if rule.slot_radius_m > keep_out else 0.0
    record["oscillation_samples"] = max(2, round(parameters.oscillation_window_s / parameters.control_period_s))
    return record


def blank_memory() -> Record:
    """The memory (1,) of a planner that has seen nothing."""
    memory = np.zeros(1, MEMORY)
    memory["history_next_s"] = -np.inf
    memory["trail_next_s"] = -np.inf
    memory["dwell_since_s"] = np.nan
    memory["guidance_next_s"] = -np.inf
    return memory


def _fill(record: Record, model: Ac2fParameters | CaptureRule, prefix: str = "") -> None:
    for name in type(model).model_fields:
        value = getattr(model, name)
        if isinstance(value, CaptureRule | VolumeParameters):
            continue
        record[prefix + name] = code_of(type(model), name, value) if isinstance(value, str) else value

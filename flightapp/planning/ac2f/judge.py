"""What the step's view means for the pursuit: capture condition, crossing, encirclement, and with them the stage."""

from __future__ import annotations

import math

import numpy as np
from numba import void

from flightapp.core.clearance import way_gap_m
from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.ac2f.history import variance_m2
from flightapp.planning.ac2f.records import MEMORY_TYPE, NUMBER, PARAMETERS_TYPE, ROWS, TRUTH, VIEW_TYPE, WHOLE, Record, code_of
from flightapp.planning.ac2f.stage import COARSE, FINE, NO_CHANGE, next_stage
from flightapp.planning.boundary import is_crossed
from flightapp.planning.capture import CaptureRule, dwell_since_s, encloses, has_dwelt

FIRST = code_of(CaptureRule, "mode", "first")


@compiled(void(MEMORY_TYPE, VIEW_TYPE, ROWS))
def _follow_evader(memory: Record, view: Record, sides: Array) -> None:
    """Closest approach since the last step, and whether the evader has crossed the boundary in it."""
    m, v = memory[0], view[0]
    v.closest_m = math.inf
    if v.target_known:
        v.closest_m = v.distance_m
        if m.has_before:
            before_n, before_e = m.before_own_n - m.before_evader_n, m.before_own_e - m.before_evader_e
            now_n, now_e = v.own_n - v.target_n, v.own_e - v.target_e
            v.closest_m = way_gap_m(before_n, before_e, now_n - before_n, now_e - before_e, 0.0)
            if not m.boundary_lost:
                m.boundary_lost = is_crossed(sides, m.before_evader_n, m.before_evader_e, v.target_n, v.target_e)
        m.before_own_n = v.own_n
        m.before_own_e = v.own_e
        m.before_evader_n = v.target_n
        m.before_evader_e = v.target_e
    m.has_before = v.target_known


@compiled(TRUTH(PARAMETERS_TYPE, VIEW_TYPE, ROWS))
def _is_surrounded(parameters: Record, view: Record, team: Array) -> bool:
    """Whether the capture's condition on positions holds now."""
    p, v = parameters[0], view[0]
    if not v.target_known or v.target_age_s > p.target_stale_s:
        return False
    if p.capture_mode == FIRST:
        return bool(v.closest_m <= p.capture_radius_m)
    if not v.team_complete or v.distance_m > p.zone_m:
        return False
    bearings = np.empty(team.shape[0] + 1)
    bearings[0] = math.atan2(v.own_e - v.target_e, v.own_n - v.target_n)
    for i in range(team.shape[0]):
        north, east = team[i, 0] - v.target_n, team[i, 1] - v.target_e
        if math.hypot(north, east) > p.zone_m:
            return False
        bearings[i + 1] = math.atan2(east, north)
    return bool(encloses(bearings, p.capture_angular_gap_min_deg))


@compiled(NUMBER(PARAMETERS_TYPE, MEMORY_TYPE, VIEW_TYPE))
def _target_age_s(parameters: Record, memory: Record, view: Record) -> float:
    """Age of the newest knowledge of the target, NaN without any; remembers where the target was when it was fresh."""
    p, m, v = parameters[0], memory[0], view[0]
    if not v.target_known:
        return v.t_s - m.seen_s if m.has_seen else math.nan
    if v.target_age_s <= p.target_stale_s or not m.has_seen:
        m.has_seen = 1
        m.seen_s = v.t_s - v.target_age_s
        m.seen_n = v.target_n
        m.seen_e = v.target_e
    return float(v.target_age_s)


@compiled(void(PARAMETERS_TYPE, MEMORY_TYPE, VIEW_TYPE, WHOLE, TRUTH))
def _enter(parameters: Record, memory: Record, view: Record, stage: int, oscillating: bool) -> None:
    m, v = memory[0], view[0]
    m.trapped_in = stage == FINE and m.stage == COARSE and oscillating
    if m.trapped_in:
        m.trapped = 1
        m.trapped_n = v.own_n
        m.trapped_e = v.own_e
    m.paused = m.stage == FINE and stage == COARSE and v.distance_m < parameters[0].fine_trigger_m
    if m.stage == FINE:
        m.turn_rad_s = 0.0
    m.stage = stage
    m.stage_since_s = v.t_s


@compiled(WHOLE(PARAMETERS_TYPE, MEMORY_TYPE, VIEW_TYPE, ROWS, ROWS, ROWS))
def judge(parameters: Record, memory: Record, view: Record, team: Array, history: Array, sides: Array) -> int:
    """Update the stage and the memory of the evader; the reason of a new stage, as an index of `stage.sentences`.

    team: (k, 4) fresh teammates now. history: (samples, 2) m. sides: (s, 4) m of the boundary.
    """
    p, m, v = parameters[0], memory[0], view[0]
    _follow_evader(memory, view, sides)
    v.surrounded = _is_surrounded(parameters, view, team)
    m.dwell_since_s = dwell_since_s(m.dwell_since_s, v.t_s, v.surrounded != 0)
    m.captured = m.captured != 0 or has_dwelt(m.dwell_since_s, v.t_s, p.capture_dwell_s)
    count, samples = m.history_count, p.oscillation_samples
    oscillating = count >= samples and variance_m2(history[count - samples : count]) < p.oscillation_variance_m2
    stage, reason = next_stage(
        parameters,
        m.stage,
        _target_age_s(parameters, memory, view),
        v.distance_m,
        v.closest_m,
        v.t_s - m.stage_since_s,
        oscillating,
        m.captured != 0,
        m.trapped_in != 0,
        m.paused != 0,
    )
    if reason != NO_CHANGE:
        _enter(parameters, memory, view, stage, oscillating)
    if m.trapped and math.hypot(v.own_n - m.trapped_n, v.own_e - m.trapped_e) > p.memory_release_m:
        m.trapped = 0
    return reason

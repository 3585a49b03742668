"""The fine stage (section 5) in the records of one step: window, roll-out, critics, choice, and what to do without a choice."""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from flightapp.core.compiled import compiled, inlined
from flightapp.core.types import Array
from flightapp.planning.ac2f.free_gap import free_gap_rad
from flightapp.planning.ac2f.looking import nose_rad, seen_share
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.records import (
    ACTION_TYPE,
    INTENT_TYPE,
    MEMORY_TYPE,
    NUMBER,
    PARAMETERS_TYPE,
    ROWS,
    VECTOR,
    VIEW_TYPE,
    Record,
    code_of,
)
from flightapp.planning.ac2f.sweep import BRAKING, COLLISION, roll_out, sweep
from flightapp.planning.ac2f.window import sample_window
from flightapp.planning.critics import best_candidate, clearance_score, heading_score, memory_score, velocity_score

TERMS = ("heading", "clearance", "velocity", "memory")
HEADING, CLEARANCE, VELOCITY, MEMORY = range(4)
GOAL = code_of(Ac2fParameters, "aim", "goal")
STANDING_M_S = 0.1  # below this speed there is no arc to brake along


class Workspace(NamedTuple):
    """What the fine stage found for each of its n candidates, turn rate by turn rate; valid until its next step.

    Of the positions the first `steps + 1` rows are valid, the start first. scores: raw, rows as TERMS; memory is 0 where its
    weight is. verdicts: 0 admissible, 1 collision, 2 braking.
    """

    speeds_m_s: Array  # (n,)
    turns_rad_s: Array  # (n,)
    north_m: Array  # (steps + 1, n)
    east_m: Array  # (steps + 1, n)
    cosines: Array  # (n,) of the heading at the end
    sines: Array  # (n,)
    clearances_m: Array  # (n,)
    scores: Array  # (4, n)
    totals: Array  # (n,) weighted sums, of the admissible
    verdicts: NDArray[np.int64]  # (n,)


def steps_of(horizon_s: float, period_s: float) -> int:
    """Steps of a roll-out over `horizon_s`."""
    return max(1, round(horizon_s / period_s))


def fine_workspace(parameters: Ac2fParameters) -> Workspace:
    """A workspace for `fine` with `parameters`."""
    n = parameters.speed_samples * parameters.turn_samples
    steps = steps_of(max(parameters.horizon_s, parameters.horizon_terminal_s), parameters.control_period_s)
    paths = np.zeros((2, steps + 1, n))
    rows = np.zeros((6, n))
    return Workspace(
        rows[0], rows[1], paths[0], paths[1], rows[2], rows[3], rows[4], np.zeros((4, n)), rows[5], np.zeros(n, np.int64)
    )


VERDICTS_TYPE = numba.types.Array(numba.int64, 1, "C")
WORKSPACE_TYPE = numba.types.NamedTuple(  # type: ignore[no-untyped-call]
    (VECTOR, VECTOR, ROWS, ROWS, VECTOR, VECTOR, VECTOR, ROWS, VECTOR, VERDICTS_TYPE), Workspace
)


@compiled(numba.void(PARAMETERS_TYPE, NUMBER, NUMBER, NUMBER, WORKSPACE_TYPE))
def _sample(parameters: Record, speed_m_s: float, turn_rad_s: float, speed_limit_m_s: float, workspace: Workspace) -> None:
    """The window: what is reached from a speed and a turn rate within one control period, slowed down to the limit."""
    gains = parameters[0]
    reach = gains.acceleration_max_m_s2 * gains.control_period_s
    low = min(max(0.0, speed_m_s - reach), gains.speed_max_m_s)
    high = min(speed_m_s + reach, gains.speed_max_m_s)
    high = min(high, max(low, speed_limit_m_s))
    turn_reach = gains.yaw_acceleration_max_rad_s2 * gains.control_period_s
    turn_low = max(-gains.yaw_rate_max_rad_s, turn_rad_s - turn_reach)
    turn_high = min(gains.yaw_rate_max_rad_s, turn_rad_s + turn_reach)
    sample_window(
        low,
        high,
        turn_low,
        turn_high,
        gains.acceleration_max_m_s2,
        gains.speed_samples,
        gains.turn_samples,
        workspace.speeds_m_s,
        workspace.turns_rad_s,
    )


@inlined
def _evaluate(
    parameters: Record,
    start_n: float,
    start_e: float,
    course_rad: float,
    aim_n: float,
    aim_e: float,
    scene: Array,
    history: Array,
    near: int,
    memory_weight: float,
    workspace: Workspace,
    action: Record,
) -> int:
    """Roll out, judge and score the candidates; the best one, or -1, with its scores and the tally in the action."""
    gains = parameters[0]
    period_s = gains.control_period_s
    horizon_s = gains.horizon_terminal_s if near != 0 else gains.horizon_s
    steps = max(1, round(horizon_s / period_s))
    north = workspace.north_m[: steps + 1]
    east = workspace.east_m[: steps + 1]
    speeds = workspace.speeds_m_s
    roll_out(
        start_n, start_e, course_rad, speeds, workspace.turns_rad_s, period_s, north, east, workspace.cosines, workspace.sines
    )
    sweep(
        scene,
        speeds,
        workspace.turns_rad_s,
        period_s,
        gains.clearance_saturation_m,
        gains.braking_m_s2,
        gains.reaction_s,
        gains.braking_steps,
        gains.admissibility != 0,
        north,
        east,
        workspace.cosines,
        workspace.sines,
        workspace.clearances_m,
        workspace.verdicts,
    )
    scores = workspace.scores
    heading_score(north[steps], east[steps], workspace.cosines, workspace.sines, aim_n, aim_e, scores[HEADING])
    clearance_score(workspace.clearances_m, gains.clearance_saturation_m, scores[CLEARANCE])
    velocity_score(speeds, scores[VELOCITY])
    if memory_weight != 0.0:
        memory_score(north[1:], east[1:], history, gains.memory_scale_m, gains.speed_samples, workspace.verdicts, scores[MEMORY])
    else:
        scores[MEMORY, :] = 0.0
    weights = np.empty(4)
    weights[HEADING] = gains.weight_velocity if near != 0 else gains.weight_heading
    weights[CLEARANCE] = gains.weight_clearance
    weights[VELOCITY] = gains.weight_heading if near != 0 else gains.weight_velocity
    weights[MEMORY] = -memory_weight
    best = best_candidate(scores, weights, workspace.verdicts, gains.raw_scores != 0, workspace.totals)
    collisions = 0
    brakings = 0
    for c in range(workspace.verdicts.shape[0]):
        collisions += 1 if workspace.verdicts[c] == COLLISION else 0
        brakings += 1 if workspace.verdicts[c] == BRAKING else 0
    found = action[0]
    found.searched = 1
    found.best = best
    found.collisions = collisions
    found.brakings = brakings
    found.weight_heading = weights[HEADING]
    found.weight_clearance = weights[CLEARANCE]
    found.weight_velocity = weights[VELOCITY]
    found.weight_memory = weights[MEMORY]
    found.heading = scores[HEADING, best] if best >= 0 else math.nan
    found.clearance = scores[CLEARANCE, best] if best >= 0 else math.nan
    found.velocity = scores[VELOCITY, best] if best >= 0 else math.nan
    found.memory = scores[MEMORY, best] if best >= 0 else math.nan
    return best


@compiled(numba.void(PARAMETERS_TYPE, MEMORY_TYPE, VIEW_TYPE, INTENT_TYPE, ROWS, ROWS, ROWS, WORKSPACE_TYPE, ACTION_TYPE))
def fine(
    parameters: Record,
    memory: Record,
    view: Record,
    intent: Record,
    scene: Array,
    unseen: Array,
    history: Array,
    workspace: Workspace,
    action: Record,
) -> None:
    """One step of the fine stage: fills the action and memory.turn_rad_s.

    scene (>= view.scene_count, 6), unseen (k, 2), history (h, 2): own past positions, oldest first, of which the last
    history_samples count. The memory penalty acts while memory.trapped is set. Yaw is not wrapped.
    """
    gains = parameters[0]
    seen = view[0]
    scene = scene[: seen.scene_count]
    history = history[max(0, history.shape[0] - gains.history_samples) :]
    wish_n = intent[0].velocity_n
    wish_e = intent[0].velocity_e
    wish = math.hypot(wish_n, wish_e)
    way_n = wish_n if wish > 0.0 else intent[0].goal_n - seen.own_n
    way_e = wish_e if wish > 0.0 else intent[0].goal_e - seen.own_e
    way = math.hypot(way_n, way_e)
    direction_n = way_n / way if way > 0.0 else 0.0
    direction_e = way_e / way if way > 0.0 else 0.0
    distance = math.hypot(seen.own_n - seen.target_n, seen.own_e - seen.target_e)
    near = distance < gains.fine_trigger_m

    # the unicycle's state: course of the blended command; standing, the nose - or any course near the evader
    speed = math.hypot(seen.base_n, seen.base_e)
    course = math.atan2(seen.base_e, seen.base_n)
    if speed < gains.standing_speed_m_s:
        course = math.atan2(direction_e, direction_n) if near else seen.own_yaw_rad
    speed = min(speed, gains.speed_max_m_s)
    turn = memory[0].turn_rad_s

    share = seen_share(wish * math.cos(course), wish * math.sin(course), unseen, gains.unseen_speed_m_s)
    _sample(parameters, speed, turn, wish * share, workspace)
    short = near and gains.terminal_adaptation != 0
    horizon_s = gains.horizon_terminal_s if short else gains.horizon_s
    aim_m = gains.aim_distance_m + gains.speed_max_m_s * horizon_s
    best = _evaluate(
        parameters,
        seen.ahead_n,
        seen.ahead_e,
        course,
        intent[0].goal_n if gains.aim == GOAL else seen.own_n + aim_m * direction_n,
        intent[0].goal_e if gains.aim == GOAL else seen.own_e + aim_m * direction_e,
        scene,
        history,
        1 if short else 0,
        gains.memory_weight if memory[0].trapped != 0 else 0.0,
        workspace,
        action,
    )
    standing = False
    if best >= 0:
        speed = workspace.speeds_m_s[best]
        turn = workspace.turns_rad_s[best]
    elif speed > STANDING_M_S:
        speed = max(0.0, speed - gains.acceleration_max_m_s2 * gains.control_period_s)
    else:
        standing = True
        speed = 0.0
        turn = 0.0
    memory[0].turn_rad_s = turn
    end = course + turn * gains.control_period_s
    velocity_n = speed * math.cos(end)
    velocity_e = speed * math.sin(end)
    within_slot_range = distance <= gains.slot_range_m
    yaw = nose_rad(
        velocity_n,
        velocity_e,
        gains.face_evader_speed_m_s,
        seen.own_n,
        seen.own_e,
        True,
        seen.target_n if within_slot_range else seen.own_n + direction_n,
        seen.target_e if within_slot_range else seen.own_e + direction_e,
        memory[0].yaw_rad,
    )
    if standing:
        gap = free_gap_rad(scene, seen.ahead_n, seen.ahead_e, gains.clearance_saturation_m)
        yaw = course if math.isnan(gap) else gap
    action[0].velocity_n = velocity_n
    action[0].velocity_e = velocity_e
    action[0].yaw_rad = yaw
    action[0].has_goal = 1
    action[0].goal_n = intent[0].goal_n
    action[0].goal_e = intent[0].goal_e

"""One decision of AC2F as one compiled call: look, judge, intend, act, remember, tell."""

from __future__ import annotations

import math

import numpy as np
from numba import void
from numpy.typing import NDArray

from flightapp.core.bearing import wrapped_rad
from flightapp.core.compiled import compiled, inlined
from flightapp.core.types import Array
from flightapp.planning.ac2f.fine import VERDICTS_TYPE, fine
from flightapp.planning.ac2f.guidance import guide
from flightapp.planning.ac2f.history import sample_position
from flightapp.planning.ac2f.judge import judge
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.pursuit import intend, velocity_to
from flightapp.planning.ac2f.reactive import hold, react, search
from flightapp.planning.ac2f.recollection import RECOLLECTION_TYPE
from flightapp.planning.ac2f.records import (
    ACTION_TYPE,
    INTENT,
    INTENT_TYPE,
    MEMORY_TYPE,
    NUMBER,
    PARAMETERS_TYPE,
    REPORT_TYPE,
    ROWS,
    TRUTH,
    VECTOR,
    VIEW,
    VIEW_TYPE,
    WHOLE,
    Record,
    code_of,
)
from flightapp.planning.ac2f.stage import FINE, HOLD, SEARCH, TRACKING
from flightapp.planning.ac2f.surroundings import look
from flightapp.planning.ac2f.workspace import POSITIONS_TYPE, workspace_of

BRAKE = code_of(Ac2fParameters, "no_admissible", "brake")


@compiled(void(PARAMETERS_TYPE, MEMORY_TYPE, VIEW_TYPE, ACTION_TYPE, ROWS))
def _remember(parameters: Record, memory: Record, view: Record, action: Record, history: Array) -> None:
    """Keep the command and the own position; hovering on command is no confinement, so it starts the history anew."""
    m, v, a = memory[0], view[0], action[0]
    m.has_command = 1
    m.command_n = a.velocity_n
    m.command_e = a.velocity_e
    m.yaw_rad = wrapped_rad(a.yaw_rad)
    sample_position(memory, v.t_s, parameters[0].control_period_s, v.own_n, v.own_e, history)
    if m.stage in (TRACKING, HOLD, SEARCH):
        m.history_count = 0


@compiled(void(PARAMETERS_TYPE, MEMORY_TYPE, VIEW_TYPE, INTENT_TYPE, ACTION_TYPE, WHOLE, REPORT_TYPE))
def _tell(parameters: Record, memory: Record, view: Record, intent: Record, action: Record, reason: int, report: Record) -> None:
    """Fill `report` with what leaves the step."""
    m, v, i, a, r = memory[0], view[0], intent[0], action[0], report[0]
    r.velocity_n = a.velocity_n
    r.velocity_e = a.velocity_e
    r.yaw_rad = m.yaw_rad
    r.stage = m.stage
    r.reason = reason
    r.has_goal = a.has_goal != 0
    r.goal_n = a.goal_n
    r.goal_e = a.goal_e
    r.target_known = v.target_known != 0
    r.distance_m = v.distance_m
    r.closest_m = v.closest_m
    r.clearance_m = v.clearance_m
    r.surrounded = v.surrounded != 0
    r.captured = m.captured != 0
    r.memory_weight = parameters[0].memory_weight if m.trapped else 0.0
    r.searched = a.searched != 0
    r.guided = m.guided != 0 and i.known != 0
    r.pursuer_count = v.team_count + 1 if i.known else 0
    r.eta_s = i.eta_s
    r.contested = i.contested != 0
    r.point_n = i.point_n
    r.point_e = i.point_e


@inlined
def _act(
    parameters: Record,
    memory: Record,
    view: Record,
    scene: Array,
    team: Array,
    etas: Array,
    unseen: Array,
    sides: Array,
    closed: bool,
    history: Array,
    regions: Array,
    recollection: Record,
    positions: Array,
    rows: Array,
    scores: Array,
    verdicts: NDArray[np.int64],
    intent: Record,
    action: Record,
) -> None:
    """What the stage does: fills `intent` with its game, and `action`."""
    p, m, v, i = parameters[0], memory[0], view[0], intent[0]
    if m.stage == HOLD:
        hold(parameters, memory, view, scene, action)
        return
    if m.stage == SEARCH or not v.target_known:
        wish_n, wish_e = velocity_to(parameters, m.seen_n - v.own_n, m.seen_e - v.own_e, 1.0)
        search(parameters, memory, view, scene, unseen, m.seen_n, m.seen_e, wish_n, wish_e, action)
        return
    count = team.shape[0] + 1
    pursuers, active, goals = np.empty((count, 2)), np.empty(count), np.empty((count, 2))
    intend(parameters, memory, view, team, etas, scene, sides, closed, pursuers, regions, active, goals, intent)
    guide(parameters, memory, view, intent, recollection)
    searched = False
    if m.stage == FINE and v.depth_m < p.leave_first_m:
        past = history[: m.history_count]
        fine(parameters, memory, view, intent, scene, unseen, past, workspace_of(positions, rows, scores, verdicts), action)
        moving = math.hypot(v.base_n, v.base_e) > p.standing_speed_m_s
        if action[0].best >= 0 or p.no_admissible == BRAKE or not moving:
            return
        m.turn_rad_s = 0.0
        searched = True
    react(
        parameters, memory, view, scene, unseen, i.goal_n, i.goal_e, i.velocity_n, i.velocity_e, 1, v.target_n, v.target_e, action
    )
    action[0].searched = searched


@compiled(
    void(
        PARAMETERS_TYPE, MEMORY_TYPE, VECTOR, VECTOR, NUMBER, NUMBER, ROWS, VECTOR, VECTOR, NUMBER, NUMBER, NUMBER, NUMBER, ROWS,
        NUMBER, ROWS, ROWS, TRUTH, ROWS, ROWS, ROWS, ROWS, RECOLLECTION_TYPE, POSITIONS_TYPE, ROWS, ROWS, VERDICTS_TYPE,
        ACTION_TYPE, REPORT_TYPE,
    )
)  # fmt: skip
def step(
    parameters: Record,
    memory: Record,
    own_position: Array,
    own_velocity: Array,
    own_yaw_rad: float,
    t_s: float,
    members: Array,
    target_position: Array,
    target_velocity: Array,
    target_t_s: float,
    target_age_s: float,
    assigned_rad: float,
    assigned_s: float,
    discs: Array,
    discs_t_s: float,
    unseen: Array,
    sides: Array,
    closed: bool,
    history: Array,
    trail: Array,
    scene: Array,
    regions: Array,
    recollection: Record,
    positions: Array,
    rows: Array,
    scores: Array,
    verdicts: NDArray[np.int64],
    action: Record,
    report: Record,
) -> None:
    """One decision from one observation: fills `report`, and where the dynamic window was searched `action`.

    Observed, as in `look`: own_position to discs_t_s; unseen (u, 2) rad; the boundary's sides (s, 4) m, closed or not. By the
    team's plan, NaN without one: assigned_rad, the own slot's bearing, assigned_s, from now until all are to be there. State:
    memory, history (samples, 2), trail (c, 3), recollection. Room: scene (>= discs + DISCS + members + 1, 6), regions
    (members + 1, 6) for the game, and the four of `workspace_arrays`.
    """
    count = members.shape[0]
    view, intent = np.zeros(1, VIEW), np.zeros(1, INTENT)
    team, etas = np.empty((count, 4)), np.empty(count + 1)
    look(
        parameters, memory, own_position, own_velocity, own_yaw_rad, t_s, members, target_position, target_velocity, target_t_s,
        target_age_s, discs, discs_t_s, unseen, team, etas[:count], recollection, scene, trail, view,
    )  # fmt: skip
    etas[count] = assigned_s
    view[0].assigned = not math.isnan(assigned_rad)
    view[0].assigned_rad = assigned_rad
    fresh = team[: view[0].team_count]
    reason = judge(parameters, memory, view, fresh, history, sides)
    _act(
        parameters, memory, view, scene, fresh, etas, unseen, sides, closed, history, regions, recollection, positions, rows,
        scores, verdicts, intent, action,
    )  # fmt: skip
    _remember(parameters, memory, view, action, history)
    _tell(parameters, memory, view, intent, action, reason, report)

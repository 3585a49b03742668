"""One observation, digested: where the vehicle and the others are now, and the scene around it."""

from __future__ import annotations

import math

import numpy as np
from numba import void

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.ac2f.disc_memory import recall_discs, remember_discs
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.pursuit import team_distance_m
from flightapp.planning.ac2f.recollection import RECOLLECTION_TYPE
from flightapp.planning.ac2f.records import (
    MEMORY_TYPE,
    NUMBER,
    PARAMETERS_TYPE,
    ROWS,
    VECTOR,
    VIEW_TYPE,
    WHOLE,
    Record,
)
from flightapp.planning.ac2f.scene import add_vehicle, deepest_m, inflate, scene_clearance_m

MEMBER_COLUMNS = 7
"""A teammate as observed: north, east, v_north, v_east, t_s of these, age_s of what was heard, eta_s (NaN: unknown)."""
TRAIL_COLUMNS = 3
"""A place of the trail: north, east, t_s."""


def trail_samples(parameters: Ac2fParameters) -> int:
    """How many samples of the others the trail must hold: those of its length, one that joins, and the present."""
    return int(parameters.vehicle_trail_s / parameters.control_period_s) + 4


@compiled(void(PARAMETERS_TYPE, MEMORY_TYPE, VECTOR, VECTOR, VIEW_TYPE))
def _look_at_self(parameters: Record, memory: Record, position: Array, velocity: Array, view: Record) -> None:
    p, m, v = parameters[0], memory[0], view[0]
    v.own_n = position[0]
    v.own_e = position[1]
    last_n = m.command_n if m.has_command else velocity[0]
    last_e = m.command_e if m.has_command else velocity[1]
    v.base_n = last_n + p.command_blend * (velocity[0] - last_n)
    v.base_e = last_e + p.command_blend * (velocity[1] - last_e)
    v.ahead_n = v.own_n + p.response_lag_s * (velocity[0] - v.base_n)
    v.ahead_e = v.own_e + p.response_lag_s * (velocity[1] - v.base_e)


@compiled(void(PARAMETERS_TYPE, ROWS, ROWS, VECTOR, VIEW_TYPE))
def _look_at_team(parameters: Record, members: Array, team: Array, etas: Array, view: Record) -> None:
    """Fill team (k, 4) and etas (k,): teammates predicted from the time of their state to the view's, the fresh ones first."""
    p, v = parameters[0], view[0]
    count = members.shape[0]
    fresh = 0
    for i in range(count):
        fresh += members[i, 5] <= p.team_stale_s
    v.team_count = fresh
    v.team_complete = fresh == count
    first, behind = 0, fresh
    for i in range(count):
        if members[i, 5] <= p.team_stale_s:
            row = first
            first += 1
        else:
            row = behind
            behind += 1
        ahead_s = min(p.prediction_max_s, max(0.0, v.t_s - members[i, 4]))
        team[row, 0] = members[i, 0] + members[i, 2] * ahead_s
        team[row, 1] = members[i, 1] + members[i, 3] * ahead_s
        team[row, 2] = members[i, 2]
        team[row, 3] = members[i, 3]
        etas[row] = members[i, 6]


@compiled(void(PARAMETERS_TYPE, VECTOR, VECTOR, NUMBER, NUMBER, VIEW_TYPE))
def _look_at_target(parameters: Record, position: Array, velocity: Array, track_t_s: float, age_s: float, view: Record) -> None:
    """The track predicted to the view's time; an age of NaN says that there is none."""
    v = view[0]
    v.target_known = not math.isnan(age_s)
    v.target_age_s = age_s
    v.distance_m = math.inf
    if v.target_known:
        ahead_s = min(parameters[0].prediction_max_s, max(0.0, v.t_s - track_t_s))
        v.target_n = position[0] + velocity[0] * ahead_s
        v.target_e = position[1] + velocity[1] * ahead_s
        v.target_vn = velocity[0]
        v.target_ve = velocity[1]
        v.distance_m = math.hypot(v.own_n - v.target_n, v.own_e - v.target_e)


@compiled(WHOLE(VIEW_TYPE, ROWS, ROWS, WHOLE))
def _write_present(view: Record, team: Array, trail: Array, start: int) -> int:
    """Write the places of all others into `trail` from row `start` on; returns the row behind them."""
    v = view[0]
    for i in range(team.shape[0]):
        trail[start + i, 0] = team[i, 0]
        trail[start + i, 1] = team[i, 1]
        trail[start + i, 2] = v.t_s
    end: int = start + team.shape[0]
    if v.target_known:
        trail[end, 0] = v.target_n
        trail[end, 1] = v.target_e
        trail[end, 2] = v.t_s
        end += 1
    return end


@compiled(WHOLE(PARAMETERS_TYPE, MEMORY_TYPE, VIEW_TYPE, ROWS, ROWS))
def follow_others(parameters: Record, memory: Record, view: Record, team: Array, trail: Array) -> int:
    """How many rows of `trail` (c, 3: north, east, t_s) tell where others are or recently were.

    The first `memory.trail_count` of them stay, one sample a period; the present places of this step are behind them.
    """
    p, m, v = parameters[0], memory[0], view[0]
    if v.t_s >= m.trail_next_s - 1e-9:
        m.trail_next_s = v.t_s + p.control_period_s
        old = max(0, m.trail_count + 2 * (team.shape[0] + 1) - trail.shape[0])
        while old < m.trail_count and v.t_s - trail[old, 2] > p.vehicle_trail_s:
            old += 1
        m.trail_count -= old
        for i in range(m.trail_count if old else 0):
            trail[i] = trail[i + old]
        m.trail_count = _write_present(view, team, trail, m.trail_count)
    return int(_write_present(view, team, trail, m.trail_count))


@compiled(void(PARAMETERS_TYPE, MEMORY_TYPE, ROWS, NUMBER, ROWS, ROWS, RECOLLECTION_TYPE, ROWS, VIEW_TYPE))
def _build_scene(
    parameters: Record,
    memory: Record,
    discs: Array,
    discs_t_s: float,
    places: Array,
    team: Array,
    recollection: Record,
    scene: Array,
    view: Record,
) -> None:
    p, v = parameters[0], view[0]
    age_s = max(0.0, v.t_s - discs_t_s)
    body_m, body_max_m = p.vehicle_disc_m, p.vehicle_radius_max_m
    count = inflate(discs, v.own_n, v.own_e, age_s, p.inflation_m, p.obstacle_range_m, places, body_m, body_max_m, scene)
    count = recall_discs(parameters, memory, view, places, recollection, scene, count)
    v.obstacle_count = count
    separation = team_distance_m(parameters, v.team_count + 1)
    for i in range(v.team_count):
        count = add_vehicle(scene, count, team[i], v.own_n, v.own_e, separation, p.obstacle_range_m)
    if v.target_known and p.evader_distance_m > 0.0 and v.target_age_s <= p.target_stale_s:
        target = np.array((v.target_n, v.target_e, v.target_vn, v.target_ve))
        count = add_vehicle(scene, count, target, v.own_n, v.own_e, p.evader_distance_m, p.obstacle_range_m)
    v.scene_count = count
    v.depth_m = deepest_m(scene[:count])
    v.clearance_m = scene_clearance_m(scene[:count], v.own_n, v.own_e, p.obstacle_range_m)


@compiled(
    void(
        PARAMETERS_TYPE, MEMORY_TYPE, VECTOR, VECTOR, NUMBER, NUMBER, ROWS, VECTOR, VECTOR, NUMBER, NUMBER, ROWS, NUMBER,
        ROWS, ROWS, VECTOR, RECOLLECTION_TYPE, ROWS, ROWS, VIEW_TYPE,
    )
)  # fmt: skip
def look(
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
    discs: Array,
    discs_t_s: float,
    unseen: Array,
    team: Array,
    etas: Array,
    recollection: Record,
    scene: Array,
    trail: Array,
    view: Record,
) -> None:
    """Fill `view`, team (k, 4), etas (k,), scene (>= n + DISCS + k + 1, 6), `trail` and `recollection` from what was observed.

    own_position, own_velocity, target_position, target_velocity: (2 or 3,) NED. members: (k, MEMBER_COLUMNS). target_age_s: NaN
    without a target. discs: (n, >=5), true at `discs_t_s`; unseen: (u, 2) rad.
    """
    view[0].t_s = t_s
    view[0].own_yaw_rad = own_yaw_rad
    _look_at_self(parameters, memory, own_position, own_velocity, view)
    _look_at_team(parameters, members, team, etas, view)
    _look_at_target(parameters, target_position, target_velocity, target_t_s, target_age_s, view)
    known = follow_others(parameters, memory, view, team, trail)
    places = trail[:known]
    remember_discs(parameters, memory, view, discs, discs_t_s, unseen, places, recollection)
    _build_scene(parameters, memory, discs, discs_t_s, places, team, recollection, scene, view)

"""What one pursuer wants before it looks at obstacles: the game, its slot around the evader, its goal and its velocity.

Three ways to pursue:

- `lead` (default): far away to the game point, nearer to the intercept of the slot's motion, and within the slot range along the
  approach to the slot, braking relative to the evader.
- `lead` where the first contact ends it (capture mode `first`, hold radius that allows contact): the same far away; within the
  slot range the pursuer that arrives first meets the evader's predicted motion, and the others fly beside it for the case of a
  miss, each on its slot: two that converge on one place would brake for each other. With `contact` = "encircled" nobody meets it
  before it is inside the hull of all.
- without `lead` (the source's literal form): at top speed to the game point and, in the fine and tracking stage or below the
  fine distance, to where the evader is. A keep-out around the evader needs the approach to a slot all the same.
"""

from __future__ import annotations

import math

import numpy as np
from numba import void

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.ac2f.apollonius_kernel import solve_game
from flightapp.planning.ac2f.approach import PLANAR_TYPE, approach_velocity, contact_velocity
from flightapp.planning.ac2f.arrival import arrival_time_s, intercept_time_s, speed_share
from flightapp.planning.ac2f.braking import braking_speed_m_s
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.records import (
    INTENT_TYPE,
    MEMORY_TYPE,
    NUMBER,
    PARAMETERS_TYPE,
    ROWS,
    TRUTH,
    VECTOR,
    VIEW_TYPE,
    WHOLE,
    Record,
    code_of,
)
from flightapp.planning.ac2f.slots import free_slot_bearing_rad, slack_rad, slot_bearing_rad
from flightapp.planning.ac2f.stage import FINE, TRACKING
from flightapp.planning.capture import CaptureRule
from flightapp.planning.geometry.hull import hull_distance_m

UNION = code_of(Ac2fParameters, "game", "union")
EVADER = code_of(Ac2fParameters, "goal", "evader")
FIRST = code_of(CaptureRule, "mode", "first")
AT_ONCE = code_of(Ac2fParameters, "contact", "at-once")
ENCLOSING_MIN = 3
"""Fewer pursuers enclose nothing."""
Planar = tuple[float, float]


@compiled(PLANAR_TYPE(NUMBER, NUMBER, NUMBER))
def _towards(north: float, east: float, speed_m_s: float) -> Planar:
    """Velocity (m/s) of `speed_m_s` in the direction of (north, east); 0 where that has none."""
    length = math.hypot(north, east)
    if length == 0.0:
        return 0.0, 0.0
    return speed_m_s * (north / length), speed_m_s * (east / length)


@compiled(PLANAR_TYPE(PARAMETERS_TYPE, NUMBER, NUMBER, NUMBER))
def velocity_to(parameters: Record, north: float, east: float, share: float) -> Planar:
    """Velocity (m/s) to a place that stands, (north, east) m away, with `share` of the top speed, braking before it."""
    p = parameters[0]
    brake = braking_speed_m_s(math.hypot(north, east), p.slot_braking_m_s2, p.reaction_s)
    return _towards(north, east, min(share * p.speed_max_m_s, brake))


@compiled(NUMBER(PARAMETERS_TYPE, WHOLE))
def team_distance_m(parameters: Record, count: int) -> float:
    """Smallest distance to keep from a teammate among `count` pursuers: less than configured only if the slots are closer."""
    p = parameters[0]
    distance_m: float = p.team_separation_m
    if count < 2:
        return distance_m
    chord_m = 2.0 * p.slot_radius_m * math.sin(math.pi / count)
    demanded_m: float = max(2.0 * p.body_radius_m + p.team_body_gap_m, p.team_chord_share * chord_m)
    return min(distance_m, demanded_m)


@compiled(NUMBER(PARAMETERS_TYPE, VIEW_TYPE, ROWS, ROWS))
def _own_slot_rad(parameters: Record, view: Record, pursuers: Array, obstacles: Array) -> float:
    """Bearing of the own slot, by the team's plan if there is one, moved off `obstacles` as far as the encirclement allows."""
    p = parameters[0]
    v = view[0]
    bearing = v.assigned_rad if v.assigned else slot_bearing_rad(v.target_n, v.target_e, pursuers)
    ahead_n = v.target_n + p.slot_look_ahead_s * v.target_vn
    ahead_e = v.target_e + p.slot_look_ahead_s * v.target_ve
    slack = slack_rad(parameters, pursuers.shape[0])
    return free_slot_bearing_rad(obstacles, ahead_n, ahead_e, p.slot_radius_m, bearing, slack, p.slot_clearance_m)


@compiled(PLANAR_TYPE(PARAMETERS_TYPE, VIEW_TYPE, TRUTH, NUMBER, WHOLE, NUMBER, NUMBER))
def _far_goal(parameters: Record, view: Record, chase: bool, slot_rad: float, count: int, game_n: float, game_e: float) -> Planar:
    """The game goal far away, the intercept of the slot's motion near the slot range, in between a blend of both.

    The game goal is moved towards the own slot, so that pursuers whose circles meet in the game point spread out early. To
    `chase` is to leave the game out.
    """
    p = parameters[0]
    v = view[0]
    slot_n = math.cos(slot_rad)
    slot_e = math.sin(slot_rad)
    place_n = v.target_n + p.slot_radius_m * slot_n
    place_e = v.target_e + p.slot_radius_m * slot_e
    time_s = intercept_time_s(place_n - v.own_n, place_e - v.own_e, v.target_vn, v.target_ve, p.speed_max_m_s)
    if math.isnan(time_s):
        return (v.target_n, v.target_e) if chase else (game_n, game_e)
    lead_n = place_n + time_s * v.target_vn
    lead_e = place_e + time_s * v.target_ve
    far = (v.distance_m - p.slot_range_m) / (p.lead_range_m - p.slot_range_m)
    share = 0.0 if chase else min(1.0, max(0.0, far))
    spread_m = share * p.goal_spread_m if count > 1 else 0.0
    goal_n = lead_n + share * (game_n - lead_n) + spread_m * slot_n
    goal_e = lead_e + share * (game_e - lead_e) + spread_m * slot_e
    return goal_n, goal_e


@compiled(NUMBER(PARAMETERS_TYPE, VIEW_TYPE, ROWS, WHOLE))
def _contact_time_s(parameters: Record, view: Record, pursuers: Array, i: int) -> float:
    """When pursuer `i` can meet the evader."""
    v = view[0]
    north, east = v.target_n - pursuers[i, 0], v.target_e - pursuers[i, 1]
    time_s: float = arrival_time_s(north, east, v.target_vn, v.target_ve, parameters[0].speed_max_m_s)
    return time_s


@compiled(TRUTH(PARAMETERS_TYPE, VIEW_TYPE, ROWS))
def may_touch(parameters: Record, view: Record, pursuers: Array) -> bool:
    """Whether the evader may be met now that `pursuers` (k, 2) are where they are."""
    if parameters[0].contact == AT_ONCE or pursuers.shape[0] < ENCLOSING_MIN:
        return True
    return bool(hull_distance_m(pursuers, view[0].target_n, view[0].target_e) < 0.0)


@compiled(TRUTH(PARAMETERS_TYPE, VIEW_TYPE, ROWS))
def goes_first(parameters: Record, view: Record, pursuers: Array) -> bool:
    """Whether of all `pursuers` (k, 2) the own one, row 0, meets the evader first; each of them finds the same one.

    Of those that arrive as good as first it is the one furthest south, then furthest west: comparing pairs could go in circles.
    """
    earliest_s = math.inf
    for i in range(pursuers.shape[0]):
        earliest_s = min(earliest_s, _contact_time_s(parameters, view, pursuers, i))
    latest_s = earliest_s + parameters[0].flank_tie_s
    if _contact_time_s(parameters, view, pursuers, 0) > latest_s:
        return False
    for i in range(1, pursuers.shape[0]):
        further = pursuers[i, 0] < pursuers[0, 0] or (pursuers[i, 0] == pursuers[0, 0] and pursuers[i, 1] < pursuers[0, 1])
        if further and _contact_time_s(parameters, view, pursuers, i) <= latest_s:
            return False
    return True


@compiled(
    void(
        PARAMETERS_TYPE,
        MEMORY_TYPE,
        VIEW_TYPE,
        ROWS,
        VECTOR,
        ROWS,
        ROWS,
        TRUTH,
        ROWS,
        ROWS,
        VECTOR,
        ROWS,
        INTENT_TYPE,
    )
)
def intend(
    parameters: Record,
    memory: Record,
    view: Record,
    team: Array,
    etas: Array,
    scene: Array,
    sides: Array,
    closed: bool,
    pursuers: Array,
    regions: Array,
    active: Array,
    goals: Array,
    intent: Record,
) -> None:
    """Fill `intent`, and the game in pursuers (k+1, 2), regions (k+1, 6), active (k+1,), goals (k+1, 2): row 0 is this vehicle.

    team: (k, 4) predicted north, east, velocities; the first `view.team_count` rows count, and that many rows more than one of
    the game's arrays. etas: (m,) s, of all teammates, fresh or not, and of the team's plan; NaN where unknown. scene: its first
    `view.obstacle_count` rows keep the slot free. sides: (s, 4) m. Once the evader has crossed the boundary the evader itself is
    the goal.
    """
    p = parameters[0]
    v = view[0]
    count = 1 + v.team_count
    pursuers[0, 0] = v.own_n
    pursuers[0, 1] = v.own_e
    for i in range(1, count):
        pursuers[i, 0] = team[i - 1, 0]
        pursuers[i, 1] = team[i - 1, 1]
    evader_speed = max(p.evader_speed_assumed_m_s, math.hypot(v.target_vn, v.target_ve))
    contested, point_n, point_e, boundary_m = solve_game(
        pursuers[:count],
        v.target_n,
        v.target_e,
        np.full(count, p.speed_max_m_s / evader_speed),
        sides,
        closed,
        p.game == UNION,
        p.goal_spacing_m,
        regions[:count],
        active[:count],
        goals[:count],
    )
    lost = memory[0].boundary_lost != 0
    wanted = intent[0]
    wanted.known = 1
    wanted.contested = contested and not lost
    wanted.point_n = point_n
    wanted.point_e = point_e
    wanted.boundary_m = boundary_m

    chase = lost or p.goal == EVADER
    own_n = v.own_n - v.target_n
    own_e = v.own_e - v.target_e
    near = v.distance_m <= p.slot_range_m
    by_contact = p.capture_mode == FIRST and p.evader_distance_m == 0.0
    if p.lead == 0 and not (near and p.evader_distance_m > 0.0):
        is_close = v.distance_m < p.fine_trigger_m or memory[0].stage == FINE or memory[0].stage == TRACKING
        wanted.goal_n = v.target_n if chase or is_close else point_n
        wanted.goal_e = v.target_e if chase or is_close else point_e
        wanted.velocity_n, wanted.velocity_e = _towards(wanted.goal_n - v.own_n, wanted.goal_e - v.own_e, p.speed_max_m_s)
        wanted.eta_s = arrival_time_s(-own_n, -own_e, v.target_vn, v.target_ve, p.speed_max_m_s)
        return

    slot_rad = _own_slot_rad(parameters, view, pursuers[:count], scene[: v.obstacle_count])
    place_n = v.target_n + p.slot_radius_m * math.cos(slot_rad)
    place_e = v.target_e + p.slot_radius_m * math.sin(slot_rad)
    wanted.eta_s = arrival_time_s(place_n - v.own_n, place_e - v.own_e, v.target_vn, v.target_ve, p.speed_max_m_s)
    if not near:
        goal_n, goal_e = _far_goal(parameters, view, chase, slot_rad, count, goals[0, 0], goals[0, 1])
        share = speed_share(parameters, wanted.eta_s, etas) if contested and boundary_m >= p.arrival_margin_m else 1.0
        wanted.goal_n = goal_n
        wanted.goal_e = goal_e
        wanted.velocity_n, wanted.velocity_e = velocity_to(parameters, goal_n - v.own_n, goal_e - v.own_e, share)
    elif not by_contact:
        keep_out_m = min(p.evader_distance_m + p.evader_path_margin_m, p.slot_radius_m) if p.evader_distance_m > 0.0 else 0.0
        wanted.goal_n = place_n
        wanted.goal_e = place_e
        wanted.velocity_n, wanted.velocity_e = approach_velocity(
            parameters, own_n, own_e, v.target_vn, v.target_ve, slot_rad, p.slot_radius_m, keep_out_m
        )
    elif may_touch(parameters, view, pursuers[:count]) and goes_first(parameters, view, pursuers[:count]):
        wanted.goal_n = v.target_n
        wanted.goal_e = v.target_e
        wanted.velocity_n, wanted.velocity_e = contact_velocity(parameters, -own_n, -own_e, v.target_vn, v.target_ve)
    else:
        wanted.goal_n = v.target_n + p.flank_radius_m * math.cos(slot_rad)
        wanted.goal_e = v.target_e + p.flank_radius_m * math.sin(slot_rad)
        wanted.velocity_n, wanted.velocity_e = approach_velocity(
            parameters, own_n, own_e, v.target_vn, v.target_ve, slot_rad, p.flank_radius_m, p.flank_radius_m
        )

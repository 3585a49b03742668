"""Coarse, tracking, search and hold: a wish deflected by obstacles and made safe, in the records of one step."""

from __future__ import annotations

import math

from numba import void

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.ac2f.adaptive import turned
from flightapp.planning.ac2f.field import deflected, field_velocity
from flightapp.planning.ac2f.looking import nose_rad, seen_share
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.records import (
    ACTION_TYPE,
    MEMORY_TYPE,
    NUMBER,
    PARAMETERS_TYPE,
    ROWS,
    VIEW_TYPE,
    WHOLE,
    Record,
    code_of,
)
from flightapp.planning.ac2f.safe_velocity import PAIR_TYPE, Braking, safe_velocity

SEARCH_VELOCITY = code_of(Ac2fParameters, "avoidance", "search")
ADAPTIVE = code_of(Ac2fParameters, "avoidance", "adaptive")


@compiled(void(PARAMETERS_TYPE, VIEW_TYPE, NUMBER, NUMBER, ACTION_TYPE))
def _command(parameters: Record, view: Record, wanted_n: float, wanted_e: float, action: Record) -> None:
    """The velocity that is nearest to the wanted one among those reached within a control period."""
    gains = parameters[0]
    seen = view[0]
    reach = gains.acceleration_max_m_s2 * gains.control_period_s
    change_n = wanted_n - seen.base_n
    change_e = wanted_e - seen.base_e
    change = math.hypot(change_n, change_e)
    if change > reach:
        change_n = change_n * reach / change
        change_e = change_e * reach / change
    north = seen.base_n + change_n
    east = seen.base_e + change_e
    speed = math.hypot(north, east)
    if speed > gains.speed_max_m_s:
        north = north * gains.speed_max_m_s / speed
        east = east * gains.speed_max_m_s / speed
    action[0].velocity_n = north
    action[0].velocity_e = east


@compiled(PAIR_TYPE(PARAMETERS_TYPE, VIEW_TYPE, ROWS, NUMBER, NUMBER))
def _safe(parameters: Record, view: Record, scene: Array, wish_n: float, wish_e: float) -> tuple[float, float]:
    gains = parameters[0]
    seen = view[0]
    braking = Braking(
        gains.braking_m_s2,
        gains.reaction_s,
        gains.manoeuvre_s,
        gains.leaving_gain_per_s,
        gains.leaving_speed_max_m_s,
        gains.excess_cost,
        gains.reached_excess_cost,
        gains.across_cost,
        gains.change_cost,
    )
    return safe_velocity(
        scene[: seen.scene_count],
        seen.ahead_n,
        seen.ahead_e,
        wish_n,
        wish_e,
        seen.base_n,
        seen.base_e,
        gains.speed_max_m_s,
        braking,
    )


@compiled(void(PARAMETERS_TYPE, MEMORY_TYPE, VIEW_TYPE, ROWS, ACTION_TYPE))
def hold(parameters: Record, memory: Record, view: Record, scene: Array, action: Record) -> None:
    """Stand, and give way to what comes. Fills velocity, yaw and has_goal of the action."""
    chosen_n, chosen_e = _safe(parameters, view, scene, 0.0, 0.0)
    _command(parameters, view, chosen_n, chosen_e, action)
    action[0].yaw_rad = memory[0].yaw_rad
    action[0].has_goal = 0
    action[0].searched = 0


@compiled(
    void(PARAMETERS_TYPE, MEMORY_TYPE, VIEW_TYPE, ROWS, ROWS, NUMBER, NUMBER, NUMBER, NUMBER, WHOLE, NUMBER, NUMBER, ACTION_TYPE)
)
def react(
    parameters: Record,
    memory: Record,
    view: Record,
    scene: Array,
    unseen: Array,
    goal_n: float,
    goal_e: float,
    wish_n: float,
    wish_e: float,
    watch: int,
    watched_n: float,
    watched_e: float,
    action: Record,
) -> None:
    """Coarse and tracking: the wish (m/s), deflected by obstacles and made safe.

    scene (>= view.scene_count, 6), unseen (k, 2). watch 1: face the place (watched_n, watched_e) while slow, where it is within
    slot_range_m. Fills velocity, yaw (not wrapped) and goal of the action. memory.yaw_rad is where the nose points.
    """
    gains = parameters[0]
    seen = view[0]
    if gains.avoidance == SEARCH_VELOCITY:
        obstacles = scene[: seen.obstacle_count]
        turned_n, turned_e = deflected(
            obstacles,
            seen.own_n,
            seen.own_e,
            wish_n,
            wish_e,
            gains.field_gain_m2,
            gains.field_influence_m,
            gains.field_repulsion_max,
            gains.repelling_gap_min_m,
        )
        chosen_n, chosen_e = _safe(parameters, view, scene, turned_n, turned_e)
    elif gains.avoidance == ADAPTIVE:
        turned_n, turned_e = turned(parameters, view, scene[: seen.obstacle_count], wish_n, wish_e, goal_n, goal_e)
        chosen_n, chosen_e = _safe(parameters, view, scene, turned_n, turned_e)
    else:
        chosen_n, chosen_e = field_velocity(
            scene[: seen.scene_count],
            seen.own_n,
            seen.own_e,
            wish_n,
            wish_e,
            seen.base_n,
            seen.base_e,
            gains.field_gain_m2,
            gains.field_influence_m,
            gains.braking_m_s2,
            gains.reaction_s,
        )
    share = seen_share(chosen_n, chosen_e, unseen, gains.unseen_speed_m_s)
    _command(parameters, view, chosen_n * share, chosen_e * share, action)
    near = watch != 0 and math.hypot(seen.own_n - watched_n, seen.own_e - watched_e) <= gains.slot_range_m
    action[0].yaw_rad = nose_rad(
        chosen_n,
        chosen_e,
        gains.face_evader_speed_m_s,
        seen.own_n,
        seen.own_e,
        near,
        watched_n,
        watched_e,
        memory[0].yaw_rad,
    )
    action[0].has_goal = 1
    action[0].goal_n = goal_n
    action[0].goal_e = goal_e
    action[0].searched = 0


@compiled(void(PARAMETERS_TYPE, MEMORY_TYPE, VIEW_TYPE, ROWS, ROWS, NUMBER, NUMBER, NUMBER, NUMBER, ACTION_TYPE))
def search(
    parameters: Record,
    memory: Record,
    view: Record,
    scene: Array,
    unseen: Array,
    place_n: float,
    place_e: float,
    wish_n: float,
    wish_e: float,
    action: Record,
) -> None:
    """Fly to the place where the evader was predicted last, by the wish (m/s) that leads there; there, turn to look around."""
    react(parameters, memory, view, scene, unseen, place_n, place_e, wish_n, wish_e, 0, 0.0, 0.0, action)
    if math.hypot(action[0].velocity_n, action[0].velocity_e) <= parameters[0].standing_speed_m_s:
        action[0].yaw_rad = view[0].own_yaw_rad + parameters[0].search_turn_rad

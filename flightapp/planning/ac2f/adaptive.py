"""The adaptive potential field as the coarse stage's avoidance: its forces turn the wish, the search makes it safe as ever.

The forces are those of the strategy `adaptive-apf`, in the plane and without memory: goal-aware repulsion (A), steering and
braking before predicted collisions (C), activation distance that follows the threat (D). Not its escapes (B), because traps are
the guidance's, and not its speed: how fast is safe is the search's to say, and slower than that loses evaders.
"""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.ac2f.records import NUMBER, PARAMETERS_TYPE, ROWS, VIEW_TYPE, Record
from flightapp.planning.ac2f.safe_velocity import PAIR_TYPE
from flightapp.planning.ac2f.scene import GRACE_M
from flightapp.planning.adaptive_apf.field import FIELD_SIZE, FORCE, TRACK_COLUMNS, sum_forces
from flightapp.planning.adaptive_apf.gains import GAINS, Gains
from flightapp.planning.adaptive_apf.parameters import AdaptiveApfParameters
from flightapp.space.bodies import BODY_COLUMNS, BOTTOM, COS, CYLINDER, EAST, KIND, LENGTH, NORTH, TOP, V_EAST, V_NORTH
from flightapp.space.distance import nearest_bodies

_DEFAULT = AdaptiveApfParameters()
ATTRACTION_1_S2, ATTRACTION_REACH_M = _DEFAULT.attraction_1_s2, _DEFAULT.attraction_reach_m
REPULSION_M4_S2, GOAL_POWER, GOAL_SCALE_MIN_M = _DEFAULT.repulsion_m4_s2, _DEFAULT.goal_power, _DEFAULT.goal_scale_min_m
REACH_M, REACH_MIN_M, REACH_MAX_M, HORIZON_S = _DEFAULT.reach_m, _DEFAULT.reach_min_m, _DEFAULT.reach_max_m, _DEFAULT.horizon_s
STEERING_SHARE = _DEFAULT.steering_share
NEAREST_MAX = 32
"""Bodies that count, the nearest first."""


@compiled(GAINS(PARAMETERS_TYPE))
def _gains(parameters: Record) -> Gains:
    """The strategy's defaults with this vehicle's limits, and with what AC2F keeps from obstacles."""
    p = parameters[0]
    acceleration = p.acceleration_max_m_s2
    return Gains(
        attraction_1_s2=ATTRACTION_1_S2,
        attraction_reach_m=ATTRACTION_REACH_M,
        repulsion=REPULSION_M4_S2,
        gap_min_m=0.05,
        force_max_m_s2=4.0 * acceleration,
        goal_aware=1.0,
        goal_power=GOAL_POWER,
        goal_bounded=1.0,
        goal_scale_min_m=GOAL_SCALE_MIN_M,
        predictive=1.0,
        kinematic=0.0,
        steering_m_s2=STEERING_SHARE * acceleration,
        braking_m_s2=p.braking_m_s2,
        speed_m_s=p.speed_max_m_s,
        horizon_s=HORIZON_S,
        delay_s=p.reaction_s,
        body_radius_m=p.body_radius_m,
        margin_m=p.inflation_m - p.body_radius_m,
        vertical_weight=0.0,
        return_1_s2=0.0,
        return_max_m_s2=0.0,
        return_zones=0.0,
        adaptive=1.0,
        printed=0.0,
        reach_m=REACH_M,
        reach_min_m=REACH_MIN_M,
        reach_max_m=REACH_MAX_M,
        obstacle_s=0.0,
        only_closing=0.0,
    )


@compiled(PAIR_TYPE(PARAMETERS_TYPE, VIEW_TYPE, ROWS, NUMBER, NUMBER, NUMBER, NUMBER))
def turned(
    parameters: Record, view: Record, obstacles: Array, wish_n: float, wish_e: float, goal_n: float, goal_e: float
) -> tuple[float, float]:
    """The wish (m/s) turned into the direction of the force where the vehicle will be; its speed stays.

    obstacles (m, SCENE_COLUMNS): inflated discs. Attraction is along the wish; the goal only says how near the end of the way is.
    """
    p, v = parameters[0], view[0]
    speed = math.hypot(wish_n, wish_e)
    count = obstacles.shape[0]
    if speed < 1e-6 or count == 0:
        return wish_n, wish_e
    bodies = np.zeros((count, BODY_COLUMNS))
    for i in range(count):
        depth = obstacles[i, 5]
        bodies[i, KIND], bodies[i, NORTH], bodies[i, EAST] = CYLINDER, obstacles[i, 0], obstacles[i, 1]
        bodies[i, LENGTH] = max(0.0, obstacles[i, 2] + (depth + GRACE_M if depth > 0.0 else 0.0) - p.inflation_m)
        bodies[i, TOP], bodies[i, BOTTOM], bodies[i, COS] = -math.inf, math.inf, 1.0
        bodies[i, V_NORTH], bodies[i, V_EAST] = obstacles[i, 3], obstacles[i, 4]
    near = min(count, NEAREST_MAX)
    which, gaps, tracks = np.zeros(near, np.int64), np.zeros((near, 4)), np.zeros((count, TRACK_COLUMNS))
    found = nearest_bodies(bodies, v.ahead_n, v.ahead_e, 0.0, 0.0, REACH_MAX_M, which, gaps)
    place, velocity, start, goal, out = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(FIELD_SIZE)
    left = math.hypot(goal_n - v.ahead_n, goal_e - v.ahead_e)
    place[0], place[1] = v.ahead_n, v.ahead_e
    velocity[0], velocity[1] = v.base_n, v.base_e
    goal[0], goal[1] = v.ahead_n + left * wish_n / speed, v.ahead_e + left * wish_e / speed
    sum_forces(bodies, which, gaps, found, place, velocity, start, goal, tracks, _gains(parameters), 0.0, 0.0, out)
    north, east = out[FORCE], out[FORCE + 1]
    force = math.hypot(north, east)
    if force < 1e-9:
        return 0.0, 0.0
    return speed * north / force, speed * east / force

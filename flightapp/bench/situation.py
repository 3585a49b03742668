"""One busy moment of a pursuit, as the parts of the control loop get to see it."""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.types import Array, Boundary, Observation, ObstacleSet, TargetTrack, TeamMember, VehicleState

DISCS = 40
PERIOD_S = 1.0 / 30.0
HEIGHT_M = 5.0
COARSE_DISTANCE_M = 30.0
FINE_DISTANCE_M = 9.0
"""The evader's, where the planner is to be in its coarse stage, and in its fine stage with the full horizon."""
BOUNDARY = Boundary(np.array([[-30.0, -50.0], [-30.0, 50.0]]), False)


def discs_around(own: VehicleState, seed: int) -> Array:
    """(DISCS, 7) small moving obstacles at 4 m to 9 m from `own`: all within reach of a fine step's horizon and braking."""
    random = np.random.default_rng(seed)
    bearing, distance = random.uniform(-math.pi, math.pi, DISCS), random.uniform(4.0, 9.0, DISCS)
    discs = np.empty((DISCS, 7))
    discs[:, 0] = own.position_ned_m[0] + distance * np.cos(bearing)
    discs[:, 1] = own.position_ned_m[1] + distance * np.sin(bearing)
    discs[:, 2] = random.uniform(0.2, 0.6, DISCS)
    discs[:, 3:5] = random.uniform(-0.3, 0.3, (DISCS, 2))
    discs[:, 5], discs[:, 6] = -np.inf, np.inf
    return discs


def straight(k: int) -> VehicleState:
    """The own state in period `k` of a flight north at 3 m/s."""
    t_s = k * PERIOD_S
    return VehicleState(t_s, np.array((3.0 * t_s, 0.0, -HEIGHT_M)), np.array((3.0, 0.2, 0.0)), 0.05)


def circling(k: int) -> VehicleState:
    """The own state in period `k` of a flight around a circle of 1 m radius: confined, as the fine stage's memory wants it."""
    t_s = k * PERIOD_S
    cos, sin = math.cos(2.0 * t_s), math.sin(2.0 * t_s)
    course = math.atan2(cos, -sin)
    return VehicleState(t_s, np.array((cos, sin, -HEIGHT_M)), np.array((-2.0 * sin, 2.0 * cos, 0.0)), course)


def teammates(own: VehicleState, names: tuple[str, ...]) -> tuple[TeamMember, ...]:
    """Teammates `names` 6 m and more to the east of `own`, flying north."""
    return tuple(
        TeamMember(
            name,
            VehicleState(
                own.t_s, own.position_ned_m + np.array((1.0, 6.0 + 3.0 * place, 0.0)), np.array((2.5, 0.0, 0.0)), own.yaw_rad
            ),
            "coarse",
            3.0,
            0.04,
        )
        for place, name in enumerate(names)
    )


def evader(own: VehicleState, distance_m: float) -> TargetTrack:
    """The evader `distance_m` to the north of `own`, coming."""
    position = own.position_ned_m + np.array((distance_m, 0.5, 0.0))
    return TargetTrack(own.t_s - 0.02, position, np.array((-1.5, 0.4, 0.0)), np.eye(6) * 0.01, 0.02)


def observation(own: VehicleState, k: int, distance_m: float) -> Observation:
    """What the first of two pursuers knows in period `k`."""
    obstacles = ObstacleSet(own.t_s - 0.05, discs_around(own, k), np.array([[1.0, -1.0]]))
    return Observation(own.t_s, PERIOD_S, own, teammates(own, ("p2",)), evader(own, distance_m), obstacles, BOUNDARY)

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
OBSERVED_S = 0.05
"""Age of the obstacles."""
UNSEEN = np.array([[1.0, -1.0]])
"""Behind, of a vehicle that looks north."""
LANE_M = 18.0
"""Length of the lane of obstacles around the vehicle."""
BOUNDARY = Boundary(np.array([[-30.0, -50.0], [-30.0, 50.0]]), False)


def _lane() -> Array:
    random = np.random.default_rng(1)
    rows = np.zeros((DISCS, 7))
    rows[:, 0] = random.uniform(0.0, LANE_M, DISCS)
    rows[:, 1] = random.uniform(1.5, 9.0, DISCS) * random.choice((-1.0, 1.0), DISCS)
    rows[:, 2], rows[:, 3] = random.uniform(0.2, 0.6, DISCS), random.uniform(-0.3, 0.3, DISCS)
    rows[:, 5], rows[:, 6] = -np.inf, np.inf
    return rows


def _ring() -> tuple[Array, Array, Array, Array]:
    """Bearing, distance, radius and speed of the discs around the origin."""
    random = np.random.default_rng(2)
    bearing, distance = random.uniform(-math.pi, math.pi, DISCS), random.uniform(5.0, 8.0, DISCS)
    return bearing, distance, random.uniform(0.2, 0.6, DISCS), random.uniform(-0.3, 0.3, DISCS)


LANE, RING = _lane(), _ring()


def straight(k: int) -> VehicleState:
    """The own state in period `k` of a flight north at 3 m/s."""
    t_s = k * PERIOD_S
    return VehicleState(t_s, np.array((3.0 * t_s, 0.0, -HEIGHT_M)), np.array((3.0, 0.2, 0.0)), 0.05)


def lane(own: VehicleState) -> ObstacleSet:
    """DISCS small moving obstacles on both sides of the flight `straight`; what falls behind comes again ahead."""
    discs, t_s = LANE.copy(), own.t_s - OBSERVED_S
    behind = float(own.position_ned_m[0]) - LANE_M / 2
    discs[:, 0] = behind + (discs[:, 0] + discs[:, 3] * t_s - behind) % LANE_M
    return ObstacleSet(t_s, discs, UNSEEN)


def circling(k: int) -> VehicleState:
    """The own state in period `k` of a flight around a circle of 1 m radius: confined, as the fine stage's memory wants it."""
    t_s = k * PERIOD_S
    cos, sin = math.cos(2.0 * t_s), math.sin(2.0 * t_s)
    course = math.atan2(cos, -sin)
    return VehicleState(t_s, np.array((cos, sin, -HEIGHT_M)), np.array((-2.0 * sin, 2.0 * cos, 0.0)), course)


def ring(own: VehicleState) -> ObstacleSet:
    """DISCS small obstacles that move around the flight `circling`, all within reach of a fine step's horizon and braking."""
    discs, t_s = np.empty((DISCS, 7)), own.t_s - OBSERVED_S
    bearing, distance, radius, speed = RING
    bearing = bearing + speed / distance * t_s
    discs[:, 0], discs[:, 1], discs[:, 2] = distance * np.cos(bearing), distance * np.sin(bearing), radius
    discs[:, 3], discs[:, 4] = -speed * np.sin(bearing), speed * np.cos(bearing)
    discs[:, 5], discs[:, 6] = -np.inf, np.inf
    return ObstacleSet(t_s, discs, UNSEEN)


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


def far(k: int) -> Observation:
    """What the first of two pursuers knows in period `k` of the flight `straight`, the evader far ahead."""
    own = straight(k)
    return _observation(own, lane(own), COARSE_DISTANCE_M)


def near(k: int) -> Observation:
    """The same of the flight `circling`, the evader near, but not within the terminal distance."""
    own = circling(k)
    return _observation(own, ring(own), FINE_DISTANCE_M)


def _observation(own: VehicleState, obstacles: ObstacleSet, distance_m: float) -> Observation:
    return Observation(own.t_s, PERIOD_S, own, teammates(own, ("p2",)), evader(own, distance_m), obstacles, BOUNDARY)

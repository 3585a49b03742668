"""A lagged, acceleration-limited point mass flown through a supervisor: what the property tests of the guards share."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence

import numpy as np

from flightapp.core.types import Array, Limits, ObstacleSet, Setpoint, TargetTrack, TeamMember, VehicleState
from flightapp.safety.api import SafetyContext
from flightapp.safety.guards.acceleration import AccelerationGuard
from flightapp.safety.guards.finite import FiniteGuard
from flightapp.safety.guards.separation import SeparationGuard
from flightapp.safety.guards.spatial import SpatialGuard
from flightapp.safety.guards.speed import SpeedGuard
from flightapp.safety.parameters import SafetyParameters
from flightapp.safety.supervisor import Supervisor

LIMITS = Limits(5.0, 5.0, 40.0, 3.0, 12.0, 2.0, 0.35, 0.45)
PARAMETERS = SafetyParameters()
LAG_S, ACCELERATION_M_S2, PERIOD_S, STEPS_A_PERIOD = 0.25, 5.0, 0.04, 4
WIND_1_S, INTEGRATOR_S = 0.25, 0.7

Wish = Callable[[float, "Body"], Array]


class Body:
    """Velocity follows the setpoint with a first-order lag of 0.25 s and at most 5 m/s2.

    Wind pushes with 0.25 /s of its speed relative to the vehicle; the velocity control, with an integrator of 0.7 s, leans
    against it as an autopilot does.
    """

    def __init__(
        self,
        name: str,
        position: Sequence[float],
        velocity: Sequence[float] = (0.0, 0.0, 0.0),
        wind_m_s: Sequence[float] = (0.0, 0.0, 0.0),
    ) -> None:
        self.wind = np.array(wind_m_s, dtype=np.float64)
        self._leaning = np.zeros(3)
        self.name = name
        self.position = np.array([*position, -5.0][:3], dtype=np.float64)
        self.velocity = np.array(velocity, dtype=np.float64)
        self.previous: Setpoint | None = None

    def state(self, t_s: float) -> VehicleState:
        return VehicleState(t_s, self.position.copy(), self.velocity.copy(), 0.0)

    def fly(self, setpoint: Setpoint) -> list[Array]:
        """One control period; the positions passed through."""
        self.previous = setpoint
        dt = PERIOD_S / STEPS_A_PERIOD
        passed = []
        for _ in range(STEPS_A_PERIOD):
            acceleration = (setpoint.velocity_ned_m_s - self.velocity) / LAG_S
            size = float(np.linalg.norm(acceleration))
            if size > ACCELERATION_M_S2:
                acceleration *= ACCELERATION_M_S2 / size
            if self.wind.any():
                self._leaning += (setpoint.velocity_ned_m_s - self.velocity) * (dt / (LAG_S * INTEGRATOR_S))
                acceleration = acceleration + self._leaning + WIND_1_S * (self.wind - self.velocity)
            self.velocity = self.velocity + acceleration * dt
            self.position = self.position + self.velocity * dt
            passed.append(self.position.copy())
        return passed


def supervisor_of(
    *spatial: SpatialGuard, separation: SeparationGuard | None = None, parameters: SafetyParameters = PARAMETERS
) -> Supervisor:
    """A supervisor with the given spatial guards and the limits that every vehicle has."""
    return Supervisor(
        stops=(FiniteGuard(),),
        limits=(SpeedGuard(),),
        spatial=spatial,
        rates=(AccelerationGuard(parameters),),
        finals=(),
        separation=separation,
    )


def context_of(
    body: Body,
    t_s: float = 0.0,
    *,
    team: tuple[TeamMember, ...] = (),
    target: TargetTrack | None = None,
    discs: Array | None = None,
    unseen: Array | None = None,
    **changes: float,
) -> SafetyContext:
    own_age_s, obstacles_age_s = changes.get("own_age_s", 0.0), changes.get("obstacles_age_s", 0.0)
    obstacles = ObstacleSet(t_s, np.zeros((0, 7)) if discs is None else discs, np.zeros((0, 2)) if unseen is None else unseen)
    dt_s = changes.get("dt_s", PERIOD_S)
    return SafetyContext(
        t_s, dt_s, body.name, body.state(t_s), own_age_s, team, target, obstacles, obstacles_age_s, body.previous, LIMITS
    )


def noisy(context: SafetyContext, random: np.random.Generator, sigma_m: float = 0.1) -> SafetyContext:
    """`context` with white noise on the own position, which is harsher than an estimator's."""
    own = context.own
    position = own.position_ned_m + random.normal(0.0, sigma_m, 3)
    return dataclasses.replace(context, own=VehicleState(own.t_s, position, own.velocity_ned_m_s, own.yaw_rad))


def member_of(body: Body, age_s: float = 0.0) -> TeamMember:
    return TeamMember(body.name, body.state(0.0), "PURSUE", None, age_s)


def target_at(position: Sequence[float], velocity: Sequence[float] = (0.0, 0.0, 0.0), age_s: float = 0.0) -> TargetTrack:
    return TargetTrack(0.0, np.array(position, dtype=float), np.array(velocity, dtype=float), np.eye(6) * 0.01, age_s)


def discs_at(*rows: tuple[float, float, float]) -> Array:
    """Static discs (n, 7) of unknown height from (north, east, radius)."""
    discs = np.zeros((len(rows), 7))
    for index, row in enumerate(rows):
        discs[index, :3] = row
    discs[:, 5], discs[:, 6] = -np.inf, np.inf
    return discs


def setpoint_of(north: float, east: float, down: float = 0.0, yaw: float = 0.0) -> Setpoint:
    return Setpoint(np.array([north, east, down]), yaw)


def random_wishes(seed: int, speed_m_s: float = 8.0, hold_s: float = 0.6) -> Wish:
    """A wish that jumps to a random planar velocity each `hold_s`."""
    rng = np.random.default_rng(seed)
    table = rng.uniform(-speed_m_s, speed_m_s, (64, 2))

    def wish(t_s: float, _: Body) -> Array:
        north, east = table[int(t_s / hold_s) % len(table)]
        return np.array([north, east, 0.0])

    return wish


def towards(point: Sequence[float], speed_m_s: float = 5.0) -> Wish:
    """Full speed at a point, slowing down only on its last centimetres."""

    def wish(_: float, body: Body) -> Array:
        offset = np.array([*point, body.position[2]][:3]) - body.position
        distance = math.hypot(offset[0], offset[1])
        return offset * (min(speed_m_s, 2.0 * distance) / max(distance, 1e-9))

    return wish


def fly(
    body: Body,
    wish: Wish,
    supervisor: Supervisor | None,
    seconds: float,
    situation: Callable[[float, Body], SafetyContext],
) -> tuple[Array, Array]:
    """Positions (n, 3) passed through and setpoint velocities (m, 3); without a supervisor the wish is flown, capped in speed."""
    path, sent = [body.position.copy()], []
    for step in range(round(seconds / PERIOD_S)):
        t_s = step * PERIOD_S
        setpoint = Setpoint(wish(t_s, body), 0.0)
        context = situation(t_s, body)
        if supervisor is None:
            setpoint = SpeedGuard().check(setpoint, context).setpoint
        else:
            setpoint = supervisor.check(setpoint, context).setpoint
        path += body.fly(setpoint)
        sent.append(setpoint.velocity_ned_m_s)
    return np.array(path), np.array(sent)

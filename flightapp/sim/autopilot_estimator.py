"""What the autopilot believes of its position and velocity: the truth plus errors that behave as PX4's do.

With GPS the errors are small and correlated; the vertical velocity carries a slow bias, so that velocity-only flight
drifts in altitude. Without GPS the velocity error grows by a seeded, constant acceleration while the health stays good
until the no-aid time-out; then the horizontal estimate is invalid.
"""

from __future__ import annotations

import math
import random
from collections import deque
from dataclasses import dataclass

from flightapp.sim.multirotor import Vector

INNOVATION_GATE_M = 5.0
"""A GPS position farther than this from the estimate is rejected, as if there were no GPS."""
_DEAD_RECKONING_ACCELERATION_M_S2 = 0.13
_CORRECTION_S = 2.0
"""Time constant with which the estimate follows the GPS."""


@dataclass(slots=True)
class GpsFault:
    """How the GPS receiver is wrong at the moment; a fault script changes it."""

    fix: bool = True
    offset_m: Vector = (0.0, 0.0, 0.0)
    deviation_m: float = 0.0
    stuck: bool = False
    delay_s: float = 0.0
    divider: float = 1.0


@dataclass(frozen=True, slots=True)
class Noise:
    """Standard deviations and correlation times of the estimate with a good GPS."""

    position_m: float = 0.04
    position_correlation_s: float = 15.0
    velocity_m_s: float = 0.03
    velocity_correlation_s: float = 0.8
    climb_bias_m_s: float = 0.03
    climb_bias_correlation_s: float = 25.0


class Estimator:
    """Errors of the estimate: estimated = true + error. Frame: mission NED."""

    def __init__(self, noise: Noise | None, *, no_aid_s: float = 5.0, seed: int = 0) -> None:
        self._noise = noise
        self._no_aid_s = no_aid_s
        self._jump_m: Vector = (0.0, 0.0, 0.0)
        self._random = random.Random(f"estimator {seed}")
        self.gps = GpsFault()
        self.position_error_m: Vector = (0.0, 0.0, 0.0)
        self.velocity_error_m_s: Vector = (0.0, 0.0, 0.0)
        self.gps_position_ned_m: Vector = (0.0, 0.0, 0.0)
        """What the receiver reports."""
        self.gps_used = True
        self.without_gps_s = 0.0
        self._wander: Vector = (0.0, 0.0, 0.0)
        self._velocity_noise: Vector = (0.0, 0.0, 0.0)
        self._climb_bias_m_s = 0.0
        self._pull: Vector = (0.0, 0.0, 0.0)
        self._drift_m_s: Vector = (0.0, 0.0, 0.0)
        self._drift_acceleration_m_s2 = self._new_drift()
        self._history: deque[tuple[float, Vector]] = deque()
        self._stuck_at: Vector | None = None
        self._next_gps_s = 0.0

    def step(self, t_s: float, dt_s: float, true_position_ned_m: Vector) -> None:
        """Advance the errors by `dt_s`."""
        self._step_noise(dt_s)
        self._read_gps(t_s, true_position_ned_m)
        innovation = tuple(
            g - p - e for g, p, e in zip(self.gps_position_ned_m, true_position_ned_m, self.position_error_m, strict=True)
        )
        near = math.hypot(innovation[0], innovation[1]) < INNOVATION_GATE_M
        if self.gps.fix and not near and self.without_gps_s >= self._no_aid_s:
            self._reset((innovation[0], innovation[1], 0.0))
            near = True
        self.gps_used = self.gps.fix and near
        pull, drift = self._pull, self._drift_m_s
        if self.gps_used:
            self.without_gps_s = 0.0
            if self.gps != GpsFault() or pull != (0.0, 0.0, 0.0) or drift != (0.0, 0.0, 0.0):
                blend = dt_s / _CORRECTION_S
                wander = self._wander
                self._pull = (
                    _settle(pull[0] + blend * (innovation[0] + wander[0])),
                    _settle(pull[1] + blend * (innovation[1] + wander[1])),
                    pull[2],
                )
                self._drift_m_s = (_settle(drift[0] * (1.0 - blend)), _settle(drift[1] * (1.0 - blend)), 0.0)
        else:
            if self.without_gps_s == 0.0:
                self._drift_acceleration_m_s2 = self._new_drift()
            self.without_gps_s += dt_s
            acceleration = self._drift_acceleration_m_s2
            self._drift_m_s = (drift[0] + acceleration[0] * dt_s, drift[1] + acceleration[1] * dt_s, 0.0)
            self._pull = (pull[0] + drift[0] * dt_s, pull[1] + drift[1] * dt_s, pull[2])
        wander, pull, drift, noise = self._wander, self._pull, self._drift_m_s, self._velocity_noise
        self.position_error_m = (wander[0] + pull[0], wander[1] + pull[1], wander[2] + pull[2])
        self.velocity_error_m_s = (noise[0] + drift[0], noise[1] + drift[1], noise[2] + self._climb_bias_m_s)

    @property
    def horizontal_valid(self) -> bool:
        return self.without_gps_s < self._no_aid_s

    def take_reset(self) -> Vector:
        """The jump of the estimate since the last call, for those who keep points to fly to."""
        jump, self._jump_m = self._jump_m, (0.0, 0.0, 0.0)
        return jump

    def _reset(self, innovation_m: Vector) -> None:
        """Give in to a GPS that has disagreed for the whole no-aid time, as PX4's estimator does."""
        pull, jump = self._pull, self._jump_m
        self._pull = (pull[0] + innovation_m[0], pull[1] + innovation_m[1], pull[2])
        self._jump_m = (jump[0] + innovation_m[0], jump[1] + innovation_m[1], 0.0)
        self._drift_m_s = (0.0, 0.0, 0.0)
        self.without_gps_s = 0.0

    def _step_noise(self, dt_s: float) -> None:
        noise = self._noise
        if noise is None:
            return
        gauss = self._random.gauss
        decay = math.exp(-dt_s / noise.position_correlation_s)
        kick = noise.position_m * math.sqrt(1.0 - decay * decay)
        a = self._wander
        self._wander = (decay * a[0] + kick * gauss(0, 1), decay * a[1] + kick * gauss(0, 1), decay * a[2] + kick * gauss(0, 1))
        decay = math.exp(-dt_s / noise.velocity_correlation_s)
        kick = noise.velocity_m_s * math.sqrt(1.0 - decay * decay)
        a = self._velocity_noise
        self._velocity_noise = (
            decay * a[0] + kick * gauss(0, 1),
            decay * a[1] + kick * gauss(0, 1),
            decay * a[2] + kick * gauss(0, 1),
        )
        decay = math.exp(-dt_s / noise.climb_bias_correlation_s)
        kick = noise.climb_bias_m_s * math.sqrt(1.0 - decay * decay)
        self._climb_bias_m_s = decay * self._climb_bias_m_s + kick * gauss(0, 1)

    def _read_gps(self, t_s: float, true_position_ned_m: Vector) -> None:
        """The receiver's newest position, 10 per second when it is well."""
        if t_s < self._next_gps_s:
            return
        gps = self.gps
        self._next_gps_s = t_s + 0.1 * gps.divider
        self._history.append((t_s, true_position_ned_m))
        while len(self._history) > 1 and self._history[1][0] <= t_s - gps.delay_s:
            self._history.popleft()
        if not gps.stuck:
            self._stuck_at = None
        elif self._stuck_at is None:
            self._stuck_at = true_position_ned_m
        base = self._stuck_at if self._stuck_at is not None else self._history[0][1]
        if gps.deviation_m > 0.0:
            gauss = self._random.gauss
            base = (base[0] + gauss(0, gps.deviation_m), base[1] + gauss(0, gps.deviation_m), base[2])
        self.gps_position_ned_m = (base[0] + gps.offset_m[0], base[1] + gps.offset_m[1], base[2] + gps.offset_m[2])

    def _new_drift(self) -> Vector:
        bearing = self._random.uniform(-math.pi, math.pi)
        return (
            _DEAD_RECKONING_ACCELERATION_M_S2 * math.cos(bearing),
            _DEAD_RECKONING_ACCELERATION_M_S2 * math.sin(bearing),
            0.0,
        )


def _settle(value: float) -> float:
    """Exactly zero once a correction is too small to matter."""
    return value if abs(value) > 1e-6 else 0.0

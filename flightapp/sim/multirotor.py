"""Translational dynamics of a velocity-controlled multirotor: pure, deterministic for a seed, no clock and no I/O.

The inner loops of the autopilot are part of the model: a velocity command becomes an acceleration command, the frame
follows it with a lag (tilting takes time) inside jerk and acceleration limits, and a slow disturbance estimate takes the
wind out, mostly but not at once. Frame: any NED frame that stands still on the ground.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import dataclass

from flightapp.core.angles import wrap_pi

GRAVITY_M_S2 = 9.80665

Vector = tuple[float, float, float]

_LIFT_OFF_M_S2 = 0.3
"""Upward acceleration demanded before the legs leave the ground."""


@dataclass(frozen=True, slots=True)
class MultirotorLimits:
    """What the frame itself can do, whatever the autopilot asks."""

    speed_max_m_s: float = 12.0
    climb_rate_max_m_s: float = 4.0
    descent_rate_max_m_s: float = 3.0
    acceleration_max_m_s2: float = 8.0
    jerk_max_m_s3: float = 60.0
    yaw_rate_max_rad_s: float = 3.5
    yaw_acceleration_max_rad_s2: float = 15.0
    response_s: float = 0.1
    """Time constant from commanded to flown acceleration."""
    velocity_gain_1_s: float = 2.2
    """Acceleration commanded per velocity error."""
    thrust_to_weight: float = 2.2
    drag_1_s: float = 0.25
    """Deceleration per air speed."""
    disturbance_estimate_s: float = 0.8
    """Time constant with which the velocity loop takes out a disturbance."""
    integral_1_s2: float | None = None
    """Instead, as PX4 does, by the integral of its velocity error with this gain (MPC_XY_VEL_I_ACC): much slower."""
    vertical_gain_1_s: float | None = None
    """Of the vertical velocity error (MPC_Z_VEL_P_ACC); None: as in the plane."""
    vertical_integral_1_s2: float | None = None
    """Of the vertical velocity error (MPC_Z_VEL_I_ACC); None: as in the plane."""


@dataclass(frozen=True, slots=True)
class Wind:
    """Mean wind (the direction it blows to), the standard deviation and correlation time of its gusts, and what comes on top."""

    north_m_s: float = 0.0
    east_m_s: float = 0.0
    gust_m_s: float = 0.0
    gust_correlation_s: float = 2.5
    gust_vertical_ratio: float = 0.3
    air: Callable[[float, float], Vector] | None = None
    """Further velocity of the air, NED in m/s, at a time since the start and a height above the ground (`sim.wind.air`)."""


@dataclass(slots=True)
class Command:
    """What the autopilot asks for. `velocity_ned_m_s` None: level, no horizontal control, `velocity_down_m_s` only."""

    velocity_ned_m_s: Vector | None = (0.0, 0.0, 0.0)
    velocity_down_m_s: float = 0.0
    acceleration_ned_m_s2: Vector = (0.0, 0.0, 0.0)
    yaw_rad: float | None = None
    yaw_rate_rad_s: float = 0.0


@dataclass(slots=True)
class Motors:
    """Health of the propulsion; a fault script changes it."""

    running: bool = False
    thrust_available: float = 1.0
    held: bool = False
    """The motors keep the last thrust and ignore commands."""
    lag_s: float = 0.0
    bias_ned_m_s2: Vector = (0.0, 0.0, 0.0)


class Multirotor:
    """State and step of one vehicle. Attributes are the true state; floats only, to be cheap at 200 Hz."""

    def __init__(
        self,
        limits: MultirotorLimits,
        *,
        position_ned_m: Vector = (0.0, 0.0, 0.0),
        yaw_rad: float = 0.0,
        wind: Wind | None = None,
        ground_down_m: float | None = None,
        seed: int = 0,
    ) -> None:
        self.limits = limits
        self.wind = Wind() if wind is None else wind
        self.ground_down_m = position_ned_m[2] if ground_down_m is None else ground_down_m
        self.position_ned_m = position_ned_m
        self.velocity_ned_m_s: Vector = (0.0, 0.0, 0.0)
        self.acceleration_ned_m_s2: Vector = (0.0, 0.0, 0.0)
        """Acceleration flown by thrust and gravity together, without drag."""
        self.yaw_rad = wrap_pi(yaw_rad)
        self.yaw_rate_rad_s = 0.0
        self.roll_rad = 0.0
        self.pitch_rad = 0.0
        self.roll_rate_rad_s = 0.0
        self.pitch_rate_rad_s = 0.0
        self.on_ground = position_ned_m[2] >= self.ground_down_m
        self.impact_speed_m_s = 0.0
        """Speed of descent at the last touch-down."""
        self.thrust_short = False
        """The motors gave less thrust than was asked for."""
        self.motors = Motors()
        self._random = random.Random(f"multirotor {seed}")
        self._gust: Vector = (0.0, 0.0, 0.0)
        self._flown_s = 0.0
        self._disturbance_estimate: Vector = (0.0, 0.0, 0.0)
        self._gain_1_s = min(
            limits.velocity_gain_1_s, 0.25 / limits.response_s, 0.9 * limits.jerk_max_m_s3 / limits.acceleration_max_m_s2
        )
        self._vertical_gain_1_s = self._gain_1_s if limits.vertical_gain_1_s is None else limits.vertical_gain_1_s

    @property
    def height_above_ground_m(self) -> float:
        return self.ground_down_m - self.position_ned_m[2]

    def step(self, dt_s: float, command: Command, velocity_error_ned_m_s: Vector = (0.0, 0.0, 0.0)) -> None:
        """Advance by `dt_s`. `velocity_error_ned_m_s`: estimated minus true velocity, as seen by the velocity loop."""
        drag = self._drag(dt_s)
        if self.motors.running:
            self._follow(dt_s, command, velocity_error_ned_m_s, drag)
            self._turn(dt_s, command)
        else:
            self.acceleration_ned_m_s2 = (0.0, 0.0, GRAVITY_M_S2)
            self._disturbance_estimate = (0.0, 0.0, 0.0)
            self.yaw_rate_rad_s = 0.0
        self._integrate(dt_s, drag)
        self._tilt(dt_s)

    def _drag(self, dt_s: float) -> Vector:
        """Acceleration by the air moving past the vehicle; none on the ground."""
        wind = self.wind
        self._flown_s += dt_s
        if wind.gust_m_s > 0.0:
            decay = math.exp(-dt_s / wind.gust_correlation_s)
            kick = wind.gust_m_s * math.sqrt(1.0 - decay * decay)
            gauss = self._random.gauss
            north, east, down = self._gust
            self._gust = (
                decay * north + kick * gauss(0.0, 1.0),
                decay * east + kick * gauss(0.0, 1.0),
                decay * down + wind.gust_vertical_ratio * kick * gauss(0.0, 1.0),
            )
        if self.on_ground:
            return (0.0, 0.0, 0.0)
        drag = self.limits.drag_1_s
        velocity, gust = self.velocity_ned_m_s, self._gust
        if wind.air is not None:
            north, east, down = wind.air(self._flown_s, self.height_above_ground_m)
            gust = (gust[0] + north, gust[1] + east, gust[2] + down)
        return (
            drag * (wind.north_m_s + gust[0] - velocity[0]),
            drag * (wind.east_m_s + gust[1] - velocity[1]),
            drag * (gust[2] - velocity[2]),
        )

    def _follow(self, dt_s: float, command: Command, error: Vector, drag: Vector) -> None:
        limits, motors = self.limits, self.motors
        if not motors.held:
            wanted = self._wanted_acceleration(dt_s, command, error)
            blend = dt_s / (limits.response_s + motors.lag_s + dt_s)
            current = self.acceleration_ned_m_s2
            change = tuple(blend * (w - c) for w, c in zip(wanted, current, strict=True))
            size = math.hypot(*change)
            jerk = limits.jerk_max_m_s3 * dt_s
            scale = jerk / size if size > jerk else 1.0
            self.acceleration_ned_m_s2 = (
                current[0] + scale * change[0],
                current[1] + scale * change[1],
                current[2] + scale * change[2],
            )
        self._limit_thrust()
        if limits.integral_1_s2 is not None:
            return
        learn = dt_s / limits.disturbance_estimate_s
        estimate = self._disturbance_estimate
        self._disturbance_estimate = (
            estimate[0] + learn * (drag[0] - estimate[0]),
            estimate[1] + learn * (drag[1] - estimate[1]),
            estimate[2] + learn * (drag[2] - estimate[2]),
        )

    def _wanted_acceleration(self, dt_s: float, command: Command, error: Vector) -> Vector:
        limits, velocity, estimate = self.limits, self.velocity_ned_m_s, self._disturbance_estimate
        gain, feed_forward, bias = self._gain_1_s, command.acceleration_ned_m_s2, self.motors.bias_ned_m_s2
        down = command.velocity_down_m_s
        if command.velocity_ned_m_s is None:
            north_m_s2 = east_m_s2 = 0.0
        else:
            north, east, down = command.velocity_ned_m_s
            speed = math.hypot(north, east)
            if speed > limits.speed_max_m_s:
                north, east = north * limits.speed_max_m_s / speed, east * limits.speed_max_m_s / speed
            north_m_s2 = gain * (north - velocity[0] - error[0]) + feed_forward[0] - estimate[0]
            east_m_s2 = gain * (east - velocity[1] - error[1]) + feed_forward[1] - estimate[1]
        down = min(max(down, -limits.climb_rate_max_m_s), limits.descent_rate_max_m_s)
        down_m_s2 = self._vertical_gain_1_s * (down - velocity[2] - error[2]) + feed_forward[2] - estimate[2]
        north_m_s2, east_m_s2, down_m_s2 = north_m_s2 + bias[0], east_m_s2 + bias[1], down_m_s2 + bias[2]
        size = math.sqrt(north_m_s2 * north_m_s2 + east_m_s2 * east_m_s2 + down_m_s2 * down_m_s2)
        if limits.integral_1_s2 is not None and size <= limits.acceleration_max_m_s2 and command.velocity_ned_m_s is not None:
            summed = limits.integral_1_s2 * dt_s
            vertical = summed if limits.vertical_integral_1_s2 is None else limits.vertical_integral_1_s2 * dt_s
            self._disturbance_estimate = (
                estimate[0] - summed * (north - velocity[0] - error[0]),
                estimate[1] - summed * (east - velocity[1] - error[1]),
                estimate[2] - vertical * (down - velocity[2] - error[2]),
            )
        if size > limits.acceleration_max_m_s2:
            scale = limits.acceleration_max_m_s2 / size
            return (north_m_s2 * scale, east_m_s2 * scale, down_m_s2 * scale)
        return (north_m_s2, east_m_s2, down_m_s2)

    def _limit_thrust(self) -> None:
        """What the motors still give of the thrust that the acceleration needs."""
        north, east, down = self.acceleration_ned_m_s2
        available = self.motors.thrust_available * self.limits.thrust_to_weight * GRAVITY_M_S2
        lift = GRAVITY_M_S2 - down
        needed = math.sqrt(north * north + east * east + lift * lift)
        self.thrust_short = needed > available
        if self.thrust_short:
            scale = available / needed
            self.acceleration_ned_m_s2 = (north * scale, east * scale, GRAVITY_M_S2 - lift * scale)

    def _turn(self, dt_s: float, command: Command) -> None:
        limits = self.limits
        if command.yaw_rad is None:
            wanted = command.yaw_rate_rad_s
        else:
            error = wrap_pi(command.yaw_rad - self.yaw_rad)
            size = min(3.0 * abs(error), 0.8 * math.sqrt(2.0 * limits.yaw_acceleration_max_rad_s2 * abs(error)))
            wanted = math.copysign(size, error)
        wanted = min(max(wanted, -limits.yaw_rate_max_rad_s), limits.yaw_rate_max_rad_s)
        change = limits.yaw_acceleration_max_rad_s2 * dt_s
        self.yaw_rate_rad_s += min(max(wanted - self.yaw_rate_rad_s, -change), change)
        if self.on_ground:
            self.yaw_rate_rad_s = 0.0
        self.yaw_rad = wrap_pi(self.yaw_rad + self.yaw_rate_rad_s * dt_s)

    def _integrate(self, dt_s: float, drag: Vector) -> None:
        acceleration = self.acceleration_ned_m_s2
        if self.on_ground:
            if acceleration[2] >= -_LIFT_OFF_M_S2 or not self.motors.running:
                self.velocity_ned_m_s = (0.0, 0.0, 0.0)
                if not self.motors.running:
                    self.acceleration_ned_m_s2 = (0.0, 0.0, 0.0)
                return
            self.on_ground = False
        position, velocity = self.position_ned_m, self.velocity_ned_m_s
        half = 0.5 * dt_s
        north = velocity[0] + (acceleration[0] + drag[0]) * dt_s
        east = velocity[1] + (acceleration[1] + drag[1]) * dt_s
        down = velocity[2] + (acceleration[2] + drag[2]) * dt_s
        down_m = position[2] + half * (velocity[2] + down)
        if down_m >= self.ground_down_m and down > 0.0:
            self.impact_speed_m_s = down
            self.on_ground = True
            self.position_ned_m = (
                position[0] + half * (velocity[0] + north),
                position[1] + half * (velocity[1] + east),
                self.ground_down_m,
            )
            self.velocity_ned_m_s = (0.0, 0.0, 0.0)
            self.acceleration_ned_m_s2 = (0.0, 0.0, 0.0)
            return
        self.position_ned_m = (position[0] + half * (velocity[0] + north), position[1] + half * (velocity[1] + east), down_m)
        self.velocity_ned_m_s = (north, east, down)

    def _tilt(self, dt_s: float) -> None:
        """Roll and pitch that point the thrust where the acceleration needs it."""
        north, east, down = (0.0, 0.0, 0.0) if self.on_ground else self.acceleration_ned_m_s2
        lift = GRAVITY_M_S2 - down
        if lift > 0.5:
            cos_yaw, sin_yaw = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
            forward, right = north * cos_yaw + east * sin_yaw, east * cos_yaw - north * sin_yaw
            pitch = -math.atan2(forward, lift)
            roll = math.atan2(right, math.hypot(forward, lift))
        else:
            pitch, roll = self.pitch_rad, self.roll_rad
        self.roll_rate_rad_s = (roll - self.roll_rad) / dt_s
        self.pitch_rate_rad_s = (pitch - self.pitch_rad) / dt_s
        self.roll_rad, self.pitch_rad = roll, pitch

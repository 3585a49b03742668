"""From the flight mode to a velocity command, as PX4's flight tasks and navigator do. Frame: mission NED; pure."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flightapp.core.angles import wrap_pi
from flightapp.sim.autopilot_modes import Mode
from flightapp.sim.autopilot_parameters import Parameters
from flightapp.sim.multirotor import Command, Vector

NAN = math.nan
_UNSET: Vector = (NAN, NAN, NAN)

FAILSAFE_DESCENT_M_S = 0.8
"""Descent of a manual mode that nobody flies."""
_BRAKED_M_S = 0.3
_ARRIVED_M = 1.0


@dataclass(frozen=True, slots=True)
class OffboardSetpoint:
    """One setpoint of the companion; NaN where it says nothing. `body` : velocity and acceleration are forward, right, down."""

    t_s: float
    position_ned_m: Vector = _UNSET
    velocity_m_s: Vector = _UNSET
    acceleration_m_s2: Vector = _UNSET
    yaw_rad: float = NAN
    yaw_rate_rad_s: float = NAN
    body: bool = False


@dataclass(frozen=True, slots=True)
class Estimate:
    """What the autopilot believes."""

    position_ned_m: Vector
    velocity_ned_m_s: Vector
    yaw_rad: float


class Navigator:
    """Keeps the points that the modes fly to."""

    def __init__(self, parameters: Parameters, ground_down_m: float) -> None:
        self._parameters = parameters
        self.home_ned_m: Vector = (0.0, 0.0, ground_down_m)
        self.takeoff_done = False
        self.cruise_speed_m_s: float | None = None
        self._hold_ned_m: Vector | None = None
        self._yaw_rad = 0.0
        self._takeoff_down_m = 0.0
        self._return_down_m = 0.0
        self._rtl_phase = "climb"
        self._ramp: Vector = (0.0, 0.0, 0.0)

    def enter(self, mode: Mode, estimate: Estimate, *, takeoff_height_m: float | None = None) -> None:
        """Start `mode` from `estimate`."""
        self._hold_ned_m = None
        self._yaw_rad = estimate.yaw_rad
        self._ramp = estimate.velocity_ned_m_s
        if mode is Mode.TAKEOFF:
            height = float(self._parameters["MIS_TAKEOFF_ALT"]) if takeoff_height_m is None else takeoff_height_m
            self._takeoff_down_m = min(self.home_ned_m[2] - height, estimate.position_ned_m[2])
            self._hold_ned_m = estimate.position_ned_m
            self.takeoff_done = False
        elif mode is Mode.RTL:
            self._rtl_phase = "climb"
            self._return_down_m = min(self.home_ned_m[2] - self._return_height_m(estimate), estimate.position_ned_m[2])

    def reposition(self, position_ned_m: Vector, yaw_rad: float) -> None:
        """Hold at another place."""
        self._hold_ned_m = position_ned_m
        if math.isfinite(yaw_rad):
            self._yaw_rad = wrap_pi(yaw_rad)

    def shift(self, jump_m: Vector) -> None:
        """Move the held point along with a jump of the estimate."""
        hold = self._hold_ned_m
        if hold is not None:
            self._hold_ned_m = (hold[0] + jump_m[0], hold[1] + jump_m[1], hold[2] + jump_m[2])

    def command(
        self, dt_s: float, mode: Mode, estimate: Estimate, setpoint: OffboardSetpoint | None, *, piloted: bool, positioned: bool
    ) -> Command:
        """The command of this moment. `piloted`: an RC pilot is there; `positioned`: the horizontal estimate is valid."""
        if not positioned or mode in (Mode.ALTCTL, Mode.MANUAL) or (mode is Mode.POSCTL and not piloted):
            descent = self._landing_speed(estimate) if mode is Mode.LAND else FAILSAFE_DESCENT_M_S
            return Command(None, 0.0 if piloted else descent, yaw_rad=self._yaw_rad)
        if mode is Mode.OFFBOARD:
            return self._offboard(estimate, setpoint)
        if mode is Mode.TAKEOFF:
            return self._takeoff(dt_s, estimate)
        if mode is Mode.LAND:
            return self._hold(dt_s, estimate, down_m_s=self._landing_speed(estimate))
        if mode is Mode.RTL:
            return self._return(dt_s, estimate)
        return self._hold(dt_s, estimate)

    def _offboard(self, estimate: Estimate, setpoint: OffboardSetpoint | None) -> Command:
        if setpoint is None:
            return Command((0.0, 0.0, 0.0), yaw_rad=self._yaw_rad)
        velocity, acceleration = setpoint.velocity_m_s, setpoint.acceleration_m_s2
        if setpoint.body:
            velocity, acceleration = _rotate(velocity, estimate.yaw_rad), _rotate(acceleration, estimate.yaw_rad)
        parameters = self._parameters
        gains = (float(parameters["MPC_XY_P"]), float(parameters["MPC_XY_P"]), float(parameters["MPC_Z_P"]))
        wanted = [0.0, 0.0, 0.0]
        forward = [0.0, 0.0, 0.0]
        for axis in range(3):
            speed, place, push = velocity[axis], setpoint.position_ned_m[axis], acceleration[axis]
            has_speed, has_place, has_push = math.isfinite(speed), math.isfinite(place), math.isfinite(push)
            if has_place:
                wanted[axis] = gains[axis] * (place - estimate.position_ned_m[axis])
            if has_speed:
                wanted[axis] += speed
            if has_push:
                forward[axis] = push
                if not has_speed and not has_place:
                    wanted[axis] = estimate.velocity_ned_m_s[axis]
        north, east, down = self._limited((wanted[0], wanted[1], wanted[2]), float(parameters["MPC_XY_VEL_MAX"]))
        command = Command((north, east, down), acceleration_ned_m_s2=(forward[0], forward[1], forward[2]))
        if math.isfinite(setpoint.yaw_rad):
            self._yaw_rad = wrap_pi(setpoint.yaw_rad)
            command.yaw_rad = self._yaw_rad
        elif math.isfinite(setpoint.yaw_rate_rad_s):
            command.yaw_rate_rad_s = setpoint.yaw_rate_rad_s
            self._yaw_rad = estimate.yaw_rad
        else:
            command.yaw_rad = self._yaw_rad
        return command

    def _takeoff(self, dt_s: float, estimate: Estimate) -> Command:
        climb = self._takeoff_down_m - estimate.position_ned_m[2]
        if abs(climb) < 0.15 and abs(estimate.velocity_ned_m_s[2]) < 0.3:
            self.takeoff_done = True
        speed = float(self._parameters["MPC_TKO_SPEED"])
        return self._hold(dt_s, estimate, down_m_s=min(max(1.5 * climb, -speed), 0.3))

    def _return(self, dt_s: float, estimate: Estimate) -> Command:
        north, east, down = estimate.position_ned_m
        home = self.home_ned_m
        away = math.hypot(home[0] - north, home[1] - east)
        if self._rtl_phase == "climb" and down - self._return_down_m < 0.5:
            self._rtl_phase = "fly"
        if self._rtl_phase == "fly" and away < _ARRIVED_M:
            self._rtl_phase = "descend"
        descend_m = min(float(self._parameters["RTL_DESCEND_ALT"]), float(self._parameters["RTL_RETURN_ALT"]))
        if self._rtl_phase == "descend" and home[2] - down < descend_m + 0.5:
            self._rtl_phase = "land"
        if self._rtl_phase == "climb":
            self._latch(estimate)
            if self._hold_ned_m is not None:
                self._hold_ned_m = (self._hold_ned_m[0], self._hold_ned_m[1], self._return_down_m)
                return self._hold(dt_s, estimate)
            climb = float(self._parameters["MPC_Z_P"]) * (self._return_down_m - down)
            return self._hold(dt_s, estimate, down_m_s=max(climb, -float(self._parameters["MPC_Z_V_AUTO_UP"])))
        if self._rtl_phase == "fly":
            if away > _ARRIVED_M:
                self._yaw_rad = math.atan2(home[1] - east, home[0] - north)
            self._hold_ned_m = (home[0], home[1], self._return_down_m)
            return self._hold(dt_s, estimate)
        self._hold_ned_m = home
        speed = self._landing_speed(estimate) if self._rtl_phase == "land" else float(self._parameters["MPC_Z_V_AUTO_DN"])
        return self._hold(dt_s, estimate, down_m_s=speed)

    def _hold(self, dt_s: float, estimate: Estimate, *, down_m_s: float | None = None) -> Command:
        """Brake, then stay where it came to rest; `down_m_s` replaces the control of the height."""
        self._latch(estimate)
        hold = self._hold_ned_m
        parameters = self._parameters
        if hold is None:
            wanted = (0.0, 0.0, 0.0)
        else:
            position, gain = estimate.position_ned_m, float(parameters["MPC_XY_P"])
            wanted = (
                gain * (hold[0] - position[0]),
                gain * (hold[1] - position[1]),
                float(parameters["MPC_Z_P"]) * (hold[2] - position[2]),
            )
        if down_m_s is not None:
            wanted = (wanted[0], wanted[1], down_m_s)
        cruise = float(parameters["MPC_XY_CRUISE"]) if self.cruise_speed_m_s is None else self.cruise_speed_m_s
        wanted = self._limited(wanted, cruise)
        upwards = wanted[2] < self._ramp[2]
        vertical = float(parameters["MPC_ACC_UP_MAX" if upwards else "MPC_ACC_DOWN_MAX"])
        self._ramp = _towards(self._ramp, wanted, float(parameters["MPC_ACC_HOR"]) * dt_s, vertical * dt_s)
        return Command(self._ramp, yaw_rad=self._yaw_rad_limited(estimate))

    def _latch(self, estimate: Estimate) -> None:
        if self._hold_ned_m is None and math.hypot(*estimate.velocity_ned_m_s) < _BRAKED_M_S:
            self._hold_ned_m = estimate.position_ned_m

    def _yaw_rad_limited(self, estimate: Estimate) -> float:
        """The next yaw on the way to the wanted one at no more than MPC_YAWRAUTO_MAX."""
        lead = math.radians(float(self._parameters["MPC_YAWRAUTO_MAX"])) / 3.0
        error = wrap_pi(self._yaw_rad - estimate.yaw_rad)
        return wrap_pi(estimate.yaw_rad + min(max(error, -lead), lead))

    def _landing_speed(self, estimate: Estimate) -> float:
        parameters = self._parameters
        slow, fast = float(parameters["MPC_LAND_SPEED"]), float(parameters["MPC_Z_V_AUTO_DN"])
        low, high = float(parameters["MPC_LAND_ALT2"]), float(parameters["MPC_LAND_ALT1"])
        height = self.home_ned_m[2] - estimate.position_ned_m[2]
        share = min(max((height - low) / (high - low), 0.0), 1.0) if high > low else 1.0
        return slow + share * (fast - slow)

    def _return_height_m(self, estimate: Estimate) -> float:
        """Height over home at which it returns: RTL_RETURN_ALT, less inside the cone about home."""
        parameters = self._parameters
        return_m, descend_m = float(parameters["RTL_RETURN_ALT"]), float(parameters["RTL_DESCEND_ALT"])
        angle = math.radians(float(parameters["RTL_CONE_ANG"]))
        if angle <= 0.0 or angle >= math.pi / 2:
            return return_m
        away = math.hypot(self.home_ned_m[0] - estimate.position_ned_m[0], self.home_ned_m[1] - estimate.position_ned_m[1])
        if away <= float(parameters["RTL_MIN_DIST"]):
            return min(descend_m, return_m)
        return min(max(away / math.tan(angle), descend_m), return_m)

    def _limited(self, velocity: Vector, speed_max_m_s: float) -> Vector:
        north, east, down = velocity
        speed = math.hypot(north, east)
        if speed > speed_max_m_s:
            north, east = north * speed_max_m_s / speed, east * speed_max_m_s / speed
        up_max, down_max = float(self._parameters["MPC_Z_VEL_MAX_UP"]), float(self._parameters["MPC_Z_VEL_MAX_DN"])
        return (north, east, min(max(down, -up_max), down_max))


def _towards(current: Vector, wanted: Vector, horizontal_step: float, vertical_step: float) -> Vector:
    """`current` on its way to `wanted`, by at most a step in the plane and another in height."""
    north, east = wanted[0] - current[0], wanted[1] - current[1]
    size = math.hypot(north, east)
    scale = 1.0 if size <= horizontal_step else horizontal_step / size
    down = min(max(wanted[2] - current[2], -vertical_step), vertical_step)
    return (current[0] + scale * north, current[1] + scale * east, current[2] + down)


def _rotate(vector: Vector, yaw_rad: float) -> Vector:
    """Forward, right, down -> north, east, down."""
    cos_yaw, sin_yaw = math.cos(yaw_rad), math.sin(yaw_rad)
    return (vector[0] * cos_yaw - vector[1] * sin_yaw, vector[0] * sin_yaw + vector[1] * cos_yaw, vector[2])

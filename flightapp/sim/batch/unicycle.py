"""The unicycle: one exact arc a control period, within the limits of speed, acceleration, turn rate and turn acceleration."""

from __future__ import annotations

import math

import numba

from flightapp.core.bearing import wrapped_rad
from flightapp.core.compiled import compiled
from flightapp.sim.batch.records import FRAME_TYPE, VEHICLE_TYPE, Records

STANDING_M_S = 0.05
STRAIGHT_RAD_S = 1e-9


@compiled(numba.void(VEHICLE_TYPE, FRAME_TYPE, numba.int64, *[numba.float64] * 4))
def steer(
    vehicles: Records, frames: Records, i: int, command_n: float, command_e: float, yaw_rad: float, period_s: float
) -> None:
    """Speed and turn rate of vehicle `i` for one control period of `period_s`: at its end, the commanded velocity if it can.

    A course error that cannot be turned in this period slows down, by its cosine, to 0 at 90 degrees: it never flies backwards.
    A command to stand turns to `yaw_rad`.
    """
    vehicle, frame = vehicles[i], frames[i]
    wanted = min(math.hypot(command_n, command_e), frame.speed_max)
    course = math.atan2(command_e, command_n) if wanted > STANDING_M_S else yaw_rad
    error = wrapped_rad(course - vehicle.yaw)
    change = frame.yaw_acceleration_max * period_s
    low = max(-frame.yaw_rate_max, vehicle.yaw_rate - change)
    high = min(frame.yaw_rate_max, vehicle.yaw_rate + change)
    turn = min(high, max(low, error / period_s))
    left = error - turn * period_s
    wanted *= max(0.0, math.cos(left))
    reach = frame.acceleration_max * period_s
    vehicle.speed = max(0.0, min(vehicle.speed + reach, max(vehicle.speed - reach, wanted)))
    vehicle.yaw_rate = turn


@compiled(numba.void(VEHICLE_TYPE, numba.int64, numba.float64))
def fly_arc(vehicles: Records, i: int, step_s: float) -> None:
    """Vehicle `i` along its arc for `step_s`, exactly."""
    vehicle = vehicles[i]
    speed, turn, course = vehicle.speed, vehicle.yaw_rate, vehicle.yaw
    after = course + turn * step_s
    if abs(turn) > STRAIGHT_RAD_S:
        radius = speed / turn
        vehicle.n += radius * (math.sin(after) - math.sin(course))
        vehicle.e += radius * (math.cos(course) - math.cos(after))
    else:
        vehicle.n += speed * step_s * math.cos(course)
        vehicle.e += speed * step_s * math.sin(course)
    vehicle.yaw = wrapped_rad(after)
    vehicle.vn = speed * math.cos(vehicle.yaw)
    vehicle.ve = speed * math.sin(vehicle.yaw)

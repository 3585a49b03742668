"""The single integrator: it flies the commanded velocity, cut to its speed limit, from the start of the control period."""

from __future__ import annotations

import math

import numba

from flightapp.core.bearing import wrapped_rad
from flightapp.core.compiled import compiled
from flightapp.sim.batch.records import FRAME_TYPE, VEHICLE_TYPE, Records


@compiled(numba.void(VEHICLE_TYPE, FRAME_TYPE, numba.int64, *[numba.float64] * 4))
def fly_straight(
    vehicles: Records, frames: Records, i: int, command_n: float, command_e: float, yaw_rad: float, step_s: float
) -> None:
    """Vehicle `i` for `step_s`, nose at `yaw_rad`."""
    vehicle = vehicles[i]
    size = math.hypot(command_n, command_e)
    scale = frames[i].speed_max / size if size > frames[i].speed_max else 1.0
    vehicle.vn, vehicle.ve = scale * command_n, scale * command_e
    vehicle.n += vehicle.vn * step_s
    vehicle.e += vehicle.ve * step_s
    vehicle.yaw = wrapped_rad(yaw_rad)

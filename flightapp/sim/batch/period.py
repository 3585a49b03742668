"""What a control period is made of in the plane and in space alike: what is near, motion, the event that comes first, its end."""

from __future__ import annotations

import math

import numba
import numpy as np
from numpy.typing import NDArray

from flightapp.core.bearing import wrapped_rad
from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.boundary import NEVER, crossing
from flightapp.sim.batch.multirotor import blow, fly_frame
from flightapp.sim.batch.records import (
    CAPTURED,
    COLLIDED,
    ESCAPED,
    FLYING,
    FRAME_TYPE,
    OBSTACLE,
    SINGLE_INTEGRATOR,
    TEAMMATE,
    UNICYCLE,
    VEHICLE_TYPE,
    WORLD_TYPE,
    Records,
)
from flightapp.sim.batch.single_integrator import fly_straight
from flightapp.sim.batch.surrounding import measure_encirclement
from flightapp.sim.batch.unicycle import STANDING_M_S, fly_arc, steer
from flightapp.sim.wind import air_speed_max, air_velocity

DOWN_M = -5.0
"""Height of the plane in which everything flies."""

_ROWS = numba.float64[:, ::1]
_LISTS = numba.int64[:, ::1]
_LIST = numba.int64[::1]
_LAYERS = numba.float64[:, :, ::1]
_AIR = numba.float64[::1]
_EVENT = numba.types.Tuple((numba.int64, numba.float64))  # type: ignore[no-untyped-call]


@compiled(numba.void(VEHICLE_TYPE, _LAYERS, numba.int64))
def keep_pose(vehicles: Records, poses: Array, step: int) -> None:
    """poses (h, n, 5: north, east, v_north, v_east, yaw): the last h sub-steps, that of `step` in row step % h."""
    row = step % len(poses)
    for i in range(len(vehicles)):
        vehicle = vehicles[i]
        poses[row, i, 0], poses[row, i, 1] = vehicle.n, vehicle.e
        poses[row, i, 2], poses[row, i, 3] = vehicle.vn, vehicle.ve
        poses[row, i, 4] = vehicle.yaw


@compiled(numba.void(WORLD_TYPE, VEHICLE_TYPE, FRAME_TYPE, _AIR, _ROWS, _LISTS, _LIST))
def select_near(
    world: Records,
    vehicles: Records,
    frames: Records,
    air: Array,
    discs: Array,
    near: NDArray[np.int64],
    counts: NDArray[np.int64],
) -> None:
    """near (n, m): the discs, `counts` (n,) of them, that vehicle i can touch or pass closer than ever in this control period.

    Moving discs always, standing ones where the way that the vehicle can make does not keep it further off.
    """
    w = world[0]
    period_s = w.sub_steps * w.sub_step_s
    for i in range(len(vehicles)):
        vehicle, frame = vehicles[i], frames[i]
        way = (max(frame.speed_max, math.hypot(vehicle.vn, vehicle.ve)) + frame.frame_acceleration * period_s) * period_s
        way += (abs(w.wind_n) + abs(w.wind_e) + 4.0 * w.gust + air_speed_max(air, -DOWN_M)) * period_s
        reach = frame.body_radius + max(0.0, w.clearance) + way
        count = 0
        for k in range(len(discs)):
            dn, de = discs[k, 0] - vehicle.n, discs[k, 1] - vehicle.e
            limit = reach + discs[k, 2]
            if k < w.moving or dn * dn + de * de < limit * limit:
                near[i, count] = k
                count += 1
        counts[i] = count


@compiled(numba.void(WORLD_TYPE, VEHICLE_TYPE, FRAME_TYPE, _AIR, _LAYERS, numba.int64))
def move(world: Records, vehicles: Records, frames: Records, air: Array, commands: Array, step: int) -> None:
    """All vehicles through sub-step `step`; commands (n, r, 3: north, east in m/s, yaw), that of period k in row k % r.

    air: as `sim.wind.drawn`.
    """
    w = world[0]
    for i in range(len(vehicles)):
        vehicle, frame = vehicles[i], frames[i]
        vehicle.before_n, vehicle.before_e = vehicle.n, vehicle.e
        if vehicle.gone == 1:
            continue
        since = step - frame.delay_steps
        row = (since // w.sub_steps) % commands.shape[1]
        command_n, command_e, yaw_rad = 0.0, 0.0, vehicle.yaw
        if since >= 0:
            command_n, command_e, yaw_rad = commands[i, row, 0], commands[i, row, 1], commands[i, row, 2]
        if frame.model == UNICYCLE:
            if since >= 0 and since % w.sub_steps == 0:
                steer(vehicles, frames, i, command_n, command_e, yaw_rad, w.sub_steps * w.sub_step_s)
            fly_arc(vehicles, i, w.sub_step_s)
            vehicle.turning += abs(vehicle.yaw_rate) * w.sub_step_s
        elif frame.model == SINGLE_INTEGRATOR:
            fly_straight(vehicles, frames, i, command_n, command_e, yaw_rad, w.sub_step_s)
        else:
            if w.gust > 0.0:
                blow(world, vehicles, i, step)
            wind_n, wind_e = w.wind_n + vehicle.gust_n, w.wind_e + vehicle.gust_e
            if len(air) > 0:
                wind_n += air_velocity(air, 0, step * w.sub_step_s, -DOWN_M)
                wind_e += air_velocity(air, 1, step * w.sub_step_s, -DOWN_M)
            fly_frame(vehicles, frames, i, command_n, command_e, yaw_rad, wind_n, wind_e, w.sub_step_s)
        vehicle.path_m += math.hypot(vehicle.n - vehicle.before_n, vehicle.e - vehicle.before_e)


@compiled(numba.float64(VEHICLE_TYPE, _ROWS))
def first_crossing(vehicles: Records, sides: Array) -> float:
    """When in the sub-step the evader meets one of `sides` (s, 4)."""
    first = NEVER
    evader = vehicles[len(vehicles) - 1]
    for k in range(len(sides)):
        met = crossing(evader.before_n, evader.before_e, evader.n, evader.e, sides[k, 0], sides[k, 1], sides[k, 2], sides[k, 3])
        first = min(first, met)
    return first


@compiled(numba.void(VEHICLE_TYPE, numba.float64))
def _cut_short(vehicles: Records, share: float) -> None:
    """Take every vehicle back to where it was after `share` of the sub-step."""
    for i in range(len(vehicles)):
        vehicle = vehicles[i]
        dn, de = vehicle.n - vehicle.before_n, vehicle.e - vehicle.before_e
        vehicle.n, vehicle.e = vehicle.before_n + share * dn, vehicle.before_e + share * de
        vehicle.path_m -= (1.0 - share) * math.hypot(dn, de)


@compiled(numba.void(VEHICLE_TYPE, numba.float64))
def _measure_jerk(vehicles: Records, period_s: float) -> None:
    """Adds the jerk of the control period that ends, from velocities at the ends of the last three."""
    for i in range(len(vehicles)):
        vehicle = vehicles[i]
        an, ae = (vehicle.vn - vehicle.last_vn) / period_s, (vehicle.ve - vehicle.last_ve) / period_s
        vehicle.jerk_sum += math.hypot(an - vehicle.last_an, ae - vehicle.last_ae) / period_s
        vehicle.last_vn, vehicle.last_ve, vehicle.last_an, vehicle.last_ae = vehicle.vn, vehicle.ve, an, ae
        vehicle.periods += 1


@compiled(numba.void(VEHICLE_TYPE, FRAME_TYPE))
def _measure_turning(vehicles: Records, frames: Records) -> None:
    """Adds the change of course in the control period that ends, of what has no course but that of its velocity."""
    for i in range(len(vehicles)):
        vehicle = vehicles[i]
        if frames[i].model != UNICYCLE and vehicle.gone == 0 and math.hypot(vehicle.vn, vehicle.ve) > STANDING_M_S:
            course = math.atan2(vehicle.ve, vehicle.vn)
            if not math.isnan(vehicle.course):
                vehicle.turning += abs(wrapped_rad(course - vehicle.course))
            vehicle.course = course


@compiled(_EVENT(WORLD_TYPE, *(numba.float64,) * 4))
def first_event(world: Records, touched: float, met: float, captured: float, crossed: float) -> tuple[int, float]:
    """The code of what ends the episode in this sub-step and when in it, from when each would: an obstacle, a teammate, the
    capture, the crossing. Of several at once the earlier named. FLYING: nothing does.
    """
    w = world[0]
    outcome, first = FLYING, touched
    if touched <= 1.0:
        outcome, w.collided_with = COLLIDED, OBSTACLE
    if met < first:
        outcome, first, w.collided_with = COLLIDED, met, TEAMMATE
    if captured < first:
        outcome, first = CAPTURED, captured
    if crossed < first:
        outcome, first = ESCAPED, crossed
    if outcome != COLLIDED:
        w.collided_with = 0
    return outcome, first


@compiled(numba.void(WORLD_TYPE, VEHICLE_TYPE, numba.int64, numba.float64))
def end_within(world: Records, vehicles: Records, sub_step: int, share: float) -> None:
    """The episode ends after `share` of the sub-step of that number within the control period: vehicles, time, encirclement."""
    w = world[0]
    _cut_short(vehicles, share)
    start_s = (w.tick * w.sub_steps + sub_step) * w.sub_step_s
    w.end_s = start_s + share * w.sub_step_s
    measure_encirclement(world, vehicles, w.end_s, w.end_s - w.tick * w.sub_steps * w.sub_step_s)


@compiled(numba.void(WORLD_TYPE, VEHICLE_TYPE, FRAME_TYPE))
def end_period(world: Records, vehicles: Records, frames: Records) -> None:
    """On to the next control period; what is measured once in each."""
    w = world[0]
    w.tick += 1
    w.end_s = w.tick * w.sub_steps * w.sub_step_s
    _measure_jerk(vehicles, w.sub_steps * w.sub_step_s)
    _measure_turning(vehicles, frames)
    measure_encirclement(world, vehicles, w.end_s, w.sub_steps * w.sub_step_s)

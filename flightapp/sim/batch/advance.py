"""One control period of all vehicles, with the first thing that ends the episode: the hot kernel of the simulation."""

from __future__ import annotations

import math

import numba
import numpy as np
from numpy.typing import NDArray

from flightapp.core.bearing import wrapped_rad
from flightapp.core.clearance import nearest_share, way_gap_m
from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.boundary import NEVER, crossing
from flightapp.sim.batch.contact import first_within
from flightapp.sim.batch.moving_discs import disc_at
from flightapp.sim.batch.multirotor import blow, fly_frame
from flightapp.sim.batch.records import (
    CAPTURED,
    COLLIDED,
    ESCAPED,
    FLYING,
    FRAME_TYPE,
    OBSTACLE,
    PAIR_TYPE,
    SINGLE_INTEGRATOR,
    TEAMMATE,
    UNICYCLE,
    VEHICLE_TYPE,
    WORLD_TYPE,
    Records,
)
from flightapp.sim.batch.single_integrator import fly_straight
from flightapp.sim.batch.surrounding import encircles, in_formation, measure_encirclement
from flightapp.sim.batch.unicycle import STANDING_M_S, fly_arc, steer
from flightapp.sim.batch.walls import first_at_wall, way_wall_distance_m
from flightapp.sim.wind import air_speed_max, air_velocity

DOWN_M = -5.0
"""Height of the plane in which everything flies."""

_ROWS = numba.float64[:, ::1]
_LISTS = numba.int64[:, ::1]
_LIST = numba.int64[::1]
_LAYERS = numba.float64[:, :, ::1]
_AIR = numba.float64[::1]


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
def _select(
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
def _move(world: Records, vehicles: Records, frames: Records, air: Array, commands: Array, step: int) -> None:
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


@compiled(numba.void(WORLD_TYPE, VEHICLE_TYPE, FRAME_TYPE, _ROWS, numba.float64[::1], _LIST, numba.int64, numba.float64))
def _stop_at_surfaces(
    world: Records,
    vehicles: Records,
    frames: Records,
    discs: Array,
    area: Array,
    near: NDArray[np.int64],
    count: int,
    end_s: float,
) -> None:
    """A solid evader slides along what it runs into."""
    evader = vehicles[len(vehicles) - 1]
    radius = frames[len(vehicles) - 1].body_radius
    for c in range(count):
        k = near[c]
        n, e = discs[k, 0], discs[k, 1]
        if k < world[0].moving:
            n, e, _, _ = disc_at(discs, k, area, end_s)
        dn, de = evader.n - n, evader.e - e
        distance, reach = math.hypot(dn, de), radius + discs[k, 2]
        if 0.0 < distance < reach:
            evader.n, evader.e = n + dn * reach / distance, e + de * reach / distance


@compiled(
    PAIR_TYPE(
        WORLD_TYPE,
        VEHICLE_TYPE,
        FRAME_TYPE,
        _ROWS,
        numba.float64[::1],
        _LISTS,
        _LIST,
        numba.float64,
        numba.float64,
        numba.boolean,
    )
)
def _obstacle_contact(
    world: Records,
    vehicles: Records,
    frames: Records,
    discs: Array,
    area: Array,
    near: NDArray[np.int64],
    counts: NDArray[np.int64],
    start_s: float,
    share: float,
    timed: bool,
) -> tuple[float, float]:
    """Smallest clearance of any pursuer (m) in the first `share` of the sub-step; if `timed`, when the first touches a disc."""
    w = world[0]
    least, first = w.clearance, NEVER
    span_s = share * w.sub_step_s
    for i in range(len(vehicles) - 1):
        vehicle, body = vehicles[i], frames[i].body_radius
        if vehicle.gone == 1:
            continue
        an, ae = vehicle.before_n, vehicle.before_e
        bn, be = an + share * (vehicle.n - an), ae + share * (vehicle.e - ae)
        for c in range(counts[i]):
            k = near[i, c]
            if k < w.moving:
                from_n, from_e, _, _ = disc_at(discs, k, area, start_s)
                to_n, to_e, _, _ = disc_at(discs, k, area, start_s + span_s)
            else:
                from_n, from_e = discs[k, 0], discs[k, 1]
                to_n, to_e = from_n, from_e
            touching = discs[k, 2] + body
            start_n, start_e, end_n, end_e = an - from_n, ae - from_e, bn - to_n, be - to_e
            gap = way_gap_m(start_n, start_e, end_n - start_n, end_e - start_e, touching)
            least = min(least, gap)
            if timed and gap <= 0.0:
                first = min(first, first_within(start_n, start_e, end_n, end_e, touching))
    return least, first


@compiled(numba.void(VEHICLE_TYPE, FRAME_TYPE, _ROWS))
def _stop_at_walls(vehicles: Records, frames: Records, walls: Array) -> None:
    """A solid evader slides along walls (w, 4), too."""
    last = len(vehicles) - 1
    evader, radius = vehicles[last], frames[last].body_radius
    for k in range(len(walls)):
        pn, pe, along_n, along_e = walls[k, 0], walls[k, 1], walls[k, 2] - walls[k, 0], walls[k, 3] - walls[k, 1]
        share = nearest_share(pn - evader.n, pe - evader.e, along_n, along_e)
        n, e = pn + share * along_n, pe + share * along_e
        dn, de = evader.n - n, evader.e - e
        distance = math.hypot(dn, de)
        if 0.0 < distance < radius:
            evader.n, evader.e = n + dn * radius / distance, e + de * radius / distance


@compiled(PAIR_TYPE(VEHICLE_TYPE, FRAME_TYPE, _ROWS, numba.float64, numba.float64, numba.boolean))
def _wall_contact(
    vehicles: Records, frames: Records, walls: Array, known_m: float, share: float, timed: bool
) -> tuple[float, float]:
    """As `_obstacle_contact`, of the edges `walls` (w, 4); the clearance is at most `known_m`."""
    least, first = known_m, NEVER
    for i in range(len(vehicles) - 1):
        vehicle, body = vehicles[i], frames[i].body_radius
        if vehicle.gone == 1:
            continue
        an, ae = vehicle.before_n, vehicle.before_e
        bn, be = an + share * (vehicle.n - an), ae + share * (vehicle.e - ae)
        for k in range(len(walls)):
            pn, pe, qn, qe = walls[k, 0], walls[k, 1], walls[k, 2], walls[k, 3]
            gap = way_wall_distance_m(an, ae, bn, be, pn, pe, qn, qe) - body
            least = min(least, gap)
            if timed and gap <= 0.0:
                first = min(first, first_at_wall(an, ae, bn, be, pn, pe, qn, qe, body))
    return least, first


@compiled(PAIR_TYPE(VEHICLE_TYPE, FRAME_TYPE, numba.float64, numba.float64))
def _teammate_contact(vehicles: Records, frames: Records, known_m: float, share: float) -> tuple[float, float]:
    """Smallest distance of two pursuers, at most `known_m`, in the first `share` of the sub-step; when two first touch."""
    least, first = known_m, NEVER
    for i in range(len(vehicles) - 1):
        for j in range(i):
            a, b = vehicles[i], vehicles[j]
            if a.gone == 1 or b.gone == 1:
                continue
            an, ae = a.before_n - b.before_n, a.before_e - b.before_e
            bn, be = an + share * (a.n - b.n - an), ae + share * (a.e - b.e - ae)
            gap = way_gap_m(an, ae, bn - an, be - ae, 0.0)
            least = min(least, gap)
            touching = frames[i].body_radius + frames[j].body_radius
            if gap <= touching:
                first = min(first, first_within(an, ae, bn, be, touching))
    return least, first


@compiled(numba.float64(VEHICLE_TYPE, numba.float64))
def _first_capture(vehicles: Records, radius_m: float) -> float:
    """When in the sub-step the first pursuer comes within `radius_m` of the evader."""
    first = NEVER
    evader = vehicles[len(vehicles) - 1]
    for i in range(len(vehicles) - 1):
        pursuer = vehicles[i]
        if pursuer.gone == 1:
            continue
        an, ae = pursuer.before_n - evader.before_n, pursuer.before_e - evader.before_e
        first = min(first, first_within(an, ae, pursuer.n - evader.n, pursuer.e - evader.e, radius_m))
    return first


@compiled(numba.float64(VEHICLE_TYPE, _ROWS))
def _first_crossing(vehicles: Records, sides: Array) -> float:
    """When in the sub-step the evader meets one of `sides` (s, 4)."""
    first = NEVER
    evader = vehicles[len(vehicles) - 1]
    for k in range(len(sides)):
        met = crossing(evader.before_n, evader.before_e, evader.n, evader.e, sides[k, 0], sides[k, 1], sides[k, 2], sides[k, 3])
        first = min(first, met)
    return first


@compiled(numba.boolean(WORLD_TYPE, VEHICLE_TYPE, numba.float64))
def _dwelt(world: Records, vehicles: Records, t_s: float) -> bool:
    """Whether the encirclement has held for long enough at `t_s`."""
    w = world[0]
    holds = in_formation(world, vehicles) if w.formation == 1 else encircles(vehicles, w.zone, w.gap_min)
    if not holds:
        w.since_s = math.nan
        return False
    if math.isnan(w.since_s):
        w.since_s = t_s
    return bool(t_s - w.since_s >= w.dwell_s - 1e-9)


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


@compiled(
    numba.int64(
        WORLD_TYPE,
        VEHICLE_TYPE,
        FRAME_TYPE,
        _AIR,
        _LAYERS,
        _ROWS,
        _ROWS,
        numba.float64[::1],
        _ROWS,
        _LAYERS,
        _LISTS,
        _LIST,
        _ROWS,
    )
)
def advance(
    world: Records,
    vehicles: Records,
    frames: Records,
    air: Array,
    commands: Array,
    discs: Array,
    walls: Array,
    area: Array,
    sides: Array,
    poses: Array,
    near: NDArray[np.int64],
    counts: NDArray[np.int64],
    states: Array,
) -> int:
    """All vehicles through control period `world.tick`, or up to the event that ends the episode: its code.

    commands (n, r, 3), discs (m, 7) at t = 0, walls (w, 4), area (4,), sides (s, 4), poses (h, n, 5) written, near (n, m) and
    counts (n,) are work space, states (2 n, 3) written: position and velocity NED of each vehicle.
    air: as `sim.wind.drawn`. Ties: collision, capture, crossing.
    """
    w = world[0]
    outcome = FLYING
    last = len(vehicles) - 1
    _select(world, vehicles, frames, air, discs, near, counts)
    for j in range(w.sub_steps):
        step = w.tick * w.sub_steps + j
        start_s = step * w.sub_step_s
        _move(world, vehicles, frames, air, commands, step)
        if w.solid == 1:
            _stop_at_surfaces(world, vehicles, frames, discs, area, near[last], counts[last], start_s + w.sub_step_s)
            _stop_at_walls(vehicles, frames, walls)
        clearance, first = _obstacle_contact(world, vehicles, frames, discs, area, near, counts, start_s, 1.0, True)
        clearance, at_wall = _wall_contact(vehicles, frames, walls, clearance, 1.0, True)
        first = min(first, at_wall)
        separation, touch = _teammate_contact(vehicles, frames, w.separation, 1.0)
        if first <= 1.0:
            outcome, w.collided_with = COLLIDED, OBSTACLE
        if touch < first:
            first, outcome, w.collided_with = touch, COLLIDED, TEAMMATE
        captured = NEVER
        if w.first == 1:
            captured = _first_capture(vehicles, w.radius)
        elif _dwelt(world, vehicles, start_s + w.sub_step_s):
            captured = 1.0
        if captured < first:
            first, outcome = captured, CAPTURED
        crossed = _first_crossing(vehicles, sides)
        if crossed < first:
            first, outcome = crossed, ESCAPED
        if outcome != FLYING:
            clearance = _obstacle_contact(world, vehicles, frames, discs, area, near, counts, start_s, first, False)[0]
            w.clearance = _wall_contact(vehicles, frames, walls, clearance, first, False)[0]
            w.separation = _teammate_contact(vehicles, frames, w.separation, first)[0]
            _cut_short(vehicles, first)
            w.end_s = start_s + first * w.sub_step_s
            measure_encirclement(world, vehicles, w.end_s, w.end_s - w.tick * w.sub_steps * w.sub_step_s)
            if outcome != COLLIDED:
                w.collided_with = 0
            break
        w.clearance, w.separation = clearance, separation
        keep_pose(vehicles, poses, step + 1)
    if outcome == FLYING:
        w.tick += 1
        w.end_s = w.tick * w.sub_steps * w.sub_step_s
        _measure_jerk(vehicles, w.sub_steps * w.sub_step_s)
        _measure_turning(vehicles, frames)
        measure_encirclement(world, vehicles, w.end_s, w.sub_steps * w.sub_step_s)
    for i in range(len(vehicles)):
        vehicle = vehicles[i]
        states[2 * i, 0], states[2 * i, 1], states[2 * i, 2] = vehicle.n, vehicle.e, DOWN_M
        states[2 * i + 1, 0], states[2 * i + 1, 1], states[2 * i + 1, 2] = vehicle.vn, vehicle.ve, 0.0
    return outcome

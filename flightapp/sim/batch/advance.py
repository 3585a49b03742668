"""One control period of all vehicles, with the first thing that ends the episode: the hot kernel of the simulation."""

from __future__ import annotations

import math

import numba
import numpy as np
from numpy.typing import NDArray

from flightapp.core.clearance import nearest_share, way_gap_m
from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.boundary import NEVER
from flightapp.sim.batch.contact import first_within
from flightapp.sim.batch.moving_discs import disc_at, disc_way
from flightapp.sim.batch.period import (
    DOWN_M,
    end_period,
    end_within,
    first_crossing,
    first_event,
    keep_pose,
    move,
    select_near,
)
from flightapp.sim.batch.records import (
    FLYING,
    FRAME_TYPE,
    PAIR_TYPE,
    VEHICLE_TYPE,
    WORLD_TYPE,
    Records,
)
from flightapp.sim.batch.surrounding import encircles, in_formation
from flightapp.sim.batch.walls import first_at_wall, way_wall_distance_m

_ROWS = numba.float64[:, ::1]
_LISTS = numba.int64[:, ::1]
_LIST = numba.int64[::1]
_LAYERS = numba.float64[:, :, ::1]
_AIR = numba.float64[::1]


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
            from_n, from_e, to_n, to_e = disc_way(discs, k, k < w.moving, area, start_s, start_s + span_s)
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
    select_near(world, vehicles, frames, air, discs, near, counts)
    for j in range(w.sub_steps):
        step = w.tick * w.sub_steps + j
        start_s = step * w.sub_step_s
        move(world, vehicles, frames, air, commands, step)
        if w.solid == 1:
            _stop_at_surfaces(world, vehicles, frames, discs, area, near[last], counts[last], start_s + w.sub_step_s)
            _stop_at_walls(vehicles, frames, walls)
        clearance, touched = _obstacle_contact(world, vehicles, frames, discs, area, near, counts, start_s, 1.0, True)
        clearance, at_wall = _wall_contact(vehicles, frames, walls, clearance, 1.0, True)
        separation, met = _teammate_contact(vehicles, frames, w.separation, 1.0)
        captured = NEVER
        if w.first == 1:
            captured = _first_capture(vehicles, w.radius)
        elif _dwelt(world, vehicles, start_s + w.sub_step_s):
            captured = 1.0
        outcome, first = first_event(world, min(touched, at_wall), met, captured, first_crossing(vehicles, sides))
        if outcome != FLYING:
            clearance = _obstacle_contact(world, vehicles, frames, discs, area, near, counts, start_s, first, False)[0]
            w.clearance = _wall_contact(vehicles, frames, walls, clearance, first, False)[0]
            w.separation = _teammate_contact(vehicles, frames, w.separation, first)[0]
            end_within(world, vehicles, j, first)
            break
        w.clearance, w.separation = clearance, separation
        keep_pose(vehicles, poses, step + 1)
    if outcome == FLYING:
        end_period(world, vehicles, frames)
    for i in range(len(vehicles)):
        vehicle = vehicles[i]
        states[2 * i, 0], states[2 * i, 1], states[2 * i, 2] = vehicle.n, vehicle.e, DOWN_M
        states[2 * i + 1, 0], states[2 * i + 1, 1], states[2 * i + 1, 2] = vehicle.vn, vehicle.ve, 0.0
    return outcome

"""One control period in space: the planar motion of `batch.period`, climb and sink beside it, contact and capture in space."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.boundary import NEVER
from flightapp.sim.batch.moving_discs import disc_way
from flightapp.sim.batch.period import end_period, end_within, first_crossing, first_event, keep_pose, move, select_near
from flightapp.sim.batch.records import FLYING, FRAME_TYPE, PAIR_TYPE, VEHICLE_TYPE, WORLD_TYPE, Records
from flightapp.sim.batch.volume.contact import cylinder_contact, first_within_reach, nearest_m

_ROWS = numba.float64[:, ::1]
_LISTS = numba.int64[:, ::1]
_LIST = numba.int64[::1]
_LAYERS = numba.float64[:, :, ::1]
_VECTOR = numba.float64[::1]

DOWN, DOWN_RATE, BEFORE = 0, 1, 2
"""Columns of heights: where a vehicle is (down, m), how fast it sinks (m/s), and where it was when the sub-step began."""
TOP, BOTTOM = 5, 6


@compiled(numba.void(WORLD_TYPE, VEHICLE_TYPE, FRAME_TYPE, _ROWS, _VECTOR, _ROWS, numba.int64))
def _climb(world: Records, vehicles: Records, frames: Records, heights: Array, climb: Array, wanted: Array, step: int) -> None:
    """All vehicles through sub-step `step`, up and down; climb (3,): largest rate, acceleration, time constant.

    wanted (n, r): down velocities, that of control period k in column k % r.
    """
    w = world[0]
    for i in range(len(vehicles)):
        heights[i, BEFORE] = heights[i, DOWN]
        if vehicles[i].gone == 1:
            continue
        since = step - frames[i].delay_steps
        rate = wanted[i, (since // w.sub_steps) % wanted.shape[1]] if since >= 0 else 0.0
        rate = min(climb[0], max(-climb[0], rate))
        change = min(1.0, w.sub_step_s / climb[2]) * (rate - heights[i, DOWN_RATE])
        reach = climb[1] * w.sub_step_s
        after = heights[i, DOWN_RATE] + min(reach, max(-reach, change))
        heights[i, DOWN] += 0.5 * w.sub_step_s * (heights[i, DOWN_RATE] + after)
        heights[i, DOWN_RATE] = after


@compiled(
    PAIR_TYPE(
        WORLD_TYPE, VEHICLE_TYPE, FRAME_TYPE, _ROWS, _ROWS, _VECTOR, _LISTS, _LIST, numba.float64, numba.float64, numba.boolean
    )
)
def _obstacle_contact(
    world: Records,
    vehicles: Records,
    frames: Records,
    heights: Array,
    discs: Array,
    area: Array,
    near: NDArray[np.int64],
    counts: NDArray[np.int64],
    start_s: float,
    share: float,
    timed: bool,
) -> tuple[float, float]:
    """As the planar one: smallest clearance of any pursuer in the first `share` of the sub-step, and the first touch."""
    w = world[0]
    least, first = w.clearance, NEVER
    span_s = share * w.sub_step_s
    for i in range(len(vehicles) - 1):
        vehicle, body = vehicles[i], frames[i].body_radius
        if vehicle.gone == 1:
            continue
        an, ae, ad = vehicle.before_n, vehicle.before_e, heights[i, BEFORE]
        bn, be = an + share * (vehicle.n - an), ae + share * (vehicle.e - ae)
        bd = ad + share * (heights[i, DOWN] - ad)
        for c in range(counts[i]):
            k = near[i, c]
            from_n, from_e, to_n, to_e = disc_way(discs, k, k < w.moving, area, start_s, start_s + span_s)
            gap, touched = cylinder_contact(
                an - from_n, ae - from_e, ad, bn - to_n, be - to_e, bd,
                discs[k, 2] + body, discs[k, TOP] - body, discs[k, BOTTOM] + body,
            )  # fmt: skip
            least = min(least, gap)
            if timed:
                first = min(first, touched)
    return least, first


@compiled(PAIR_TYPE(VEHICLE_TYPE, FRAME_TYPE, _ROWS, numba.float64, numba.float64))
def _teammate_contact(vehicles: Records, frames: Records, heights: Array, known_m: float, share: float) -> tuple[float, float]:
    """Smallest distance of two pursuers, at most `known_m`, in the first `share` of the sub-step; when two first touch."""
    least, first = known_m, NEVER
    for i in range(len(vehicles) - 1):
        for j in range(i):
            a, b = vehicles[i], vehicles[j]
            if a.gone == 1 or b.gone == 1:
                continue
            an, ae, ad = a.before_n - b.before_n, a.before_e - b.before_e, heights[i, BEFORE] - heights[j, BEFORE]
            bn, be = an + share * (a.n - b.n - an), ae + share * (a.e - b.e - ae)
            bd = ad + share * (heights[i, DOWN] - heights[j, DOWN] - ad)
            least = min(least, nearest_m(an, ae, ad, bn, be, bd))
            first = min(first, first_within_reach(an, ae, ad, bn, be, bd, frames[i].body_radius + frames[j].body_radius))
    return least, first


@compiled(numba.float64(VEHICLE_TYPE, _ROWS, numba.float64))
def _first_capture(vehicles: Records, heights: Array, radius_m: float) -> float:
    """When in the sub-step the first pursuer comes within `radius_m` of the evader, in space."""
    first, last = NEVER, len(vehicles) - 1
    evader = vehicles[last]
    for i in range(last):
        pursuer = vehicles[i]
        if pursuer.gone == 1:
            continue
        an, ae = pursuer.before_n - evader.before_n, pursuer.before_e - evader.before_e
        ad, bd = heights[i, BEFORE] - heights[last, BEFORE], heights[i, DOWN] - heights[last, DOWN]
        first = min(first, first_within_reach(an, ae, ad, pursuer.n - evader.n, pursuer.e - evader.e, bd, radius_m))
    return first


@compiled(
    numba.int64(
        WORLD_TYPE, VEHICLE_TYPE, FRAME_TYPE, _ROWS, _VECTOR, _ROWS, _VECTOR, _LAYERS, _ROWS, _VECTOR, _ROWS, _LAYERS, _LISTS,
        _LIST,
    )
)  # fmt: skip
def advance_in_space(
    world: Records,
    vehicles: Records,
    frames: Records,
    heights: Array,
    climb: Array,
    wanted: Array,
    air: Array,
    commands: Array,
    discs: Array,
    area: Array,
    sides: Array,
    poses: Array,
    near: NDArray[np.int64],
    counts: NDArray[np.int64],
) -> int:
    """All vehicles through control period `world.tick`, or up to the event that ends the episode: its code.

    heights (n, 3) and wanted (n, r) as above; the rest as `batch.advance.advance`, where the evader is not solid, there are no
    walls, and the first contact captures. Ties: collision, capture, crossing.
    """
    w = world[0]
    select_near(world, vehicles, frames, air, discs, near, counts)
    for j in range(w.sub_steps):
        step = w.tick * w.sub_steps + j
        start_s = step * w.sub_step_s
        move(world, vehicles, frames, air, commands, step)
        _climb(world, vehicles, frames, heights, climb, wanted, step)
        clearance, touched = _obstacle_contact(world, vehicles, frames, heights, discs, area, near, counts, start_s, 1.0, True)
        separation, met = _teammate_contact(vehicles, frames, heights, w.separation, 1.0)
        captured = _first_capture(vehicles, heights, w.radius)
        outcome, first = first_event(world, touched, met, captured, first_crossing(vehicles, sides))
        if outcome != FLYING:
            w.clearance = _obstacle_contact(world, vehicles, frames, heights, discs, area, near, counts, start_s, first, False)[0]
            w.separation = _teammate_contact(vehicles, frames, heights, w.separation, first)[0]
            end_within(world, vehicles, j, first)
            for i in range(len(vehicles)):
                heights[i, DOWN] = heights[i, BEFORE] + first * (heights[i, DOWN] - heights[i, BEFORE])
            return outcome
        w.clearance, w.separation = clearance, separation
        keep_pose(vehicles, poses, step + 1)
    end_period(world, vehicles, frames)
    return FLYING

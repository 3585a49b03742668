"""What each vehicle sees: discs in range and field of view, not behind nearer ones, with latency and noise; one call for all."""

from __future__ import annotations

import math

import numba
import numpy as np
from numpy.typing import NDArray

from flightapp.core.bearing import wrapped_rad
from flightapp.core.clearance import nearest_share
from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.sim.batch.moving_discs import disc_at
from flightapp.sim.batch.noise import normal
from flightapp.sim.batch.records import FRAME_TYPE, SENSOR_TYPE, WORLD_TYPE, Records

RADIUS_MIN_M = 0.02
EPSILON_RAD = 1e-12

_ROWS = numba.float64[:, ::1]
_LAYERS = numba.float64[:, :, ::1]


@compiled(numba.boolean(_ROWS, numba.int64, numba.int64, numba.float64, numba.float64))
def hidden(views: Array, count: int, j: int, low: float, high: float) -> bool:
    """Whether nearer discs cover disc `j` from `low` to `high` (rad about its own bearing).

    views (count, 3): bearing of the centre, half the angle covered (rad), distance of the surface (m).
    """
    at = low
    for _ in range(count):
        reached = at
        for k in range(count):
            if k != j and views[k, 2] < views[j, 2]:
                middle = wrapped_rad(views[k, 0] - views[j, 0])
                if middle - views[k, 1] <= at + EPSILON_RAD:
                    reached = max(reached, middle + views[k, 1])
        if reached >= high:
            return True
        if reached <= at + EPSILON_RAD:
            return False
        at = reached
    return False


@compiled(numba.boolean(numba.float64, numba.float64, numba.float64))
def _in_view(bearing: float, half: float, half_view: float) -> bool:
    """Whether any part of a disc at `bearing` from the nose is in the field of view."""
    return half_view >= math.pi or abs(wrapped_rad(bearing)) - half < half_view


@compiled(numba.int64(WORLD_TYPE, SENSOR_TYPE, FRAME_TYPE, _ROWS, numba.float64[::1], _LAYERS, numba.int64, _ROWS, _ROWS, _ROWS))
def _look(
    world: Records,
    sensors: Records,
    frames: Records,
    discs: Array,
    area: Array,
    poses: Array,
    i: int,
    views: Array,
    found: Array,
    rows: Array,
) -> int:
    """Writes what vehicle `i` sees to `rows` and says how many; views (m, 3) and found (m, 5) are work space."""
    w, sensor = world[0], sensors[i]
    now = w.tick * w.sub_steps
    step = max(0, now - sensor.latency_steps)
    pose = poses[step % len(poses)]
    n, e, yaw = pose[i, 0], pose[i, 1], pose[i, 4]
    t_s = step * w.sub_step_s
    count = 0
    total = len(discs) + (len(pose) if sensor.sees_vehicles == 1 else 0)
    open_air = len(discs) - w.walls if sensor.sees_walls == 0 else len(discs)
    for k in range(total):
        if open_air <= k < len(discs):
            continue
        if k < w.moving:
            disc_n, disc_e, vn, ve = disc_at(discs, k, area, t_s)
            radius = discs[k, 2]
        elif k < len(discs):
            disc_n, disc_e, vn, ve, radius = discs[k, 0], discs[k, 1], 0.0, 0.0, discs[k, 2]
        else:
            other = k - len(discs)
            if other == i or sensors[other].gone == 1:
                continue
            disc_n, disc_e, vn, ve = pose[other, 0], pose[other, 1], 0.0, 0.0
            radius = frames[other].body_radius
        dn, de = disc_n - n, disc_e - e
        reach = sensor.range + radius
        if dn * dn + de * de >= reach * reach:
            continue
        if sensor.half_view < math.pi or sensor.occlusion == 1:
            distance = math.hypot(dn, de)
            half = math.asin(radius / distance) if distance > radius else math.pi
            bearing = math.atan2(de, dn)
            if sensor.occlusion == 0 and not _in_view(bearing - yaw, half, sensor.half_view):
                continue
            views[count, 0], views[count, 1], views[count, 2] = bearing, half, distance - radius
        found[count, 0], found[count, 1], found[count, 2] = disc_n, disc_e, radius
        found[count, 3], found[count, 4], found[count, 5] = vn, ve, k
        count += 1
    seen = 0
    for j in range(count):
        if sensor.occlusion == 1:
            if not _in_view(views[j, 0] - yaw, views[j, 1], sensor.half_view):
                continue
            low, high = -views[j, 1], views[j, 1]
            if sensor.half_view < 0.5 * math.pi:
                middle = wrapped_rad(yaw - views[j, 0])
                low, high = max(low, middle - sensor.half_view), min(high, middle + sensor.half_view)
            if hidden(views, count, j, low, high):
                continue
        for column in range(5):
            rows[seen, column] = found[j, column]
        k = int(found[j, 5])
        if sensor.position_noise > 0.0:
            rows[seen, 0] += sensor.position_noise * normal(w.sensing_key, w.tick, i, 3 * k)
            rows[seen, 1] += sensor.position_noise * normal(w.sensing_key, w.tick, i, 3 * k + 1)
        if sensor.radius_noise > 0.0:
            noisy = rows[seen, 2] + sensor.radius_noise * normal(w.sensing_key, w.tick, i, 3 * k + 2)
            rows[seen, 2] = max(RADIUS_MIN_M, noisy)
        rows[seen, 5], rows[seen, 6] = -math.inf, math.inf
        seen += 1
    return seen


@compiled(numba.boolean(WORLD_TYPE, SENSOR_TYPE, _ROWS, numba.float64[::1], _LAYERS))
def target_in_sight(world: Records, sensors: Records, discs: Array, area: Array, poses: Array) -> bool:
    """Whether some pursuer had the evader's centre in its range and field of view, past all discs, a target latency ago."""
    w = world[0]
    step = max(0, w.tick * w.sub_steps - w.target_latency_steps)
    pose = poses[step % len(poses)]
    last = len(pose) - 1
    t_s = step * w.sub_step_s
    for i in range(last):
        if sensors[i].gone == 1:
            continue
        n, e = pose[i, 0], pose[i, 1]
        dn, de = pose[last, 0] - n, pose[last, 1] - e
        length2 = dn * dn + de * de
        if length2 > w.target_range * w.target_range:
            continue
        if not _in_view(math.atan2(de, dn) - pose[i, 4], 0.0, sensors[i].half_view):
            continue
        free = True
        for k in range(len(discs)):
            disc_n, disc_e = discs[k, 0], discs[k, 1]
            if k < w.moving:
                disc_n, disc_e, _, _ = disc_at(discs, k, area, t_s)
            on, oe = disc_n - n, disc_e - e
            fraction = nearest_share(-on, -oe, dn, de)
            gap_n, gap_e = on - fraction * dn, oe - fraction * de
            if gap_n * gap_n + gap_e * gap_e < discs[k, 2] * discs[k, 2]:
                free = False
                break
        if free:
            return True
    return False


@compiled(
    numba.void(
        WORLD_TYPE,
        SENSOR_TYPE,
        FRAME_TYPE,
        _ROWS,
        numba.float64[::1],
        _LAYERS,
        _ROWS,
        _ROWS,
        _LAYERS,
        numba.int64[::1],
        _ROWS,
    )
)
def sense(
    world: Records,
    sensors: Records,
    frames: Records,
    discs: Array,
    area: Array,
    poses: Array,
    views: Array,
    found: Array,
    rows: Array,
    counts: NDArray[np.int64],
    unseen: Array,
) -> None:
    """rows (n, m + n, 7): the discs that each vehicle sees at `world.tick`, counts (n,) of them; `world.target_seen`.

    unseen (n, 2) written: the sector outside the field of view, rad, for those that do not see all around.
    discs (m, 7) at t = 0, area (4,), poses (h, n, 5); views (m + n, 3) and found (m + n, 6) are work space.
    """
    for i in range(len(sensors)):
        counts[i] = _look(world, sensors, frames, discs, area, poses, i, views, found, rows[i])
        half_view = sensors[i].half_view
        if half_view < math.pi:
            step = max(0, world[0].tick * world[0].sub_steps - sensors[i].latency_steps)
            yaw = poses[step % len(poses), i, 4]
            unseen[i, 0], unseen[i, 1] = wrapped_rad(yaw + half_view), wrapped_rad(yaw - half_view)
    if world[0].target_needs_sight == 1:
        world[0].target_seen = target_in_sight(world, sensors, discs, area, poses)

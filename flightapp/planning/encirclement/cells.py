"""Where one pursuer may be (safety cell), where it should be (target cell), and the velocity that keeps it there.

The safety cell is what mates' and obstacles' half-planes leave; everything that is said about collisions is said about it. The
target cell is the part of it that is nearer to the pursuer than to the evader, inside the box around the evader: its centroid is
the goal, and no more. Wang et al., arXiv 2312.01326, section III, with two cells where they have one.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numba

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.ac2f.braking import braking_speed_m_s
from flightapp.planning.geometry.convex import centroid, clipped, nearest_in

ROOM_TO_SPARE_M = 10.0
"""The box that bounds the safety cell reaches this far beyond everything of interest."""


class Cells(NamedTuple):
    """All floats: from a kernel."""

    safety_corners: float
    safety_area_m2: float
    target_corners: float
    target_area_m2: float
    centroid_n: float
    centroid_e: float
    near_evader_n: float
    """The point nearest to the evader in what is safe and on the own side of it."""
    near_evader_e: float
    near_own_n: float
    """The point of the safety cell nearest to the own position: this one where it is inside."""
    near_own_e: float


_CELLS = numba.types.NamedUniTuple(numba.float64, len(Cells._fields), Cells)  # type: ignore[no-untyped-call]
_NUMBER = numba.float64
_ROWS = numba.float64[:, ::1]
_WHOLE = numba.int64


@compiled("i8(f8[:,::1],i8,f8,f8,f8,f8,f8,f8[:,::1])")
def _cut(
    corners: Array, count: int, from_n: float, from_e: float, normal_n: float, normal_e: float, room_m: float, spare: Array
) -> int:
    """`clipped` in place."""
    kept = clipped(corners, count, from_n, from_e, normal_n, normal_e, room_m, spare)
    for i in range(kept):
        corners[i, 0] = spare[i, 0]
        corners[i, 1] = spare[i, 1]
    return kept


@compiled("i8(f8,f8,f8,f8,f8[:,::1])")
def _box(n: float, e: float, half_n: float, half_e: float, corners: Array) -> int:
    """The box of these half sizes around (n, e), anticlockwise in (north, east)."""
    corners[0, 0] = corners[3, 0] = n - half_n
    corners[1, 0] = corners[2, 0] = n + half_n
    corners[0, 1] = corners[1, 1] = e - half_e
    corners[2, 1] = corners[3, 1] = e + half_e
    return 4


@compiled("i8(f8[:,::1],i8,f8,f8,f8[:,::1],i8,f8[:,::1])")
def _cut_by_planes(corners: Array, count: int, n: float, e: float, planes: Array, plane_count: int, spare: Array) -> int:
    """What `planes` of an owner at (n, e) leave of a polygon; they are sorted by their room, least first."""
    for i in range(1, plane_count):
        normal_n = planes[i, 0]
        normal_e = planes[i, 1]
        room = planes[i, 2]
        k = i
        while k > 0 and planes[k - 1, 2] > room:
            planes[k, 0] = planes[k - 1, 0]
            planes[k, 1] = planes[k - 1, 1]
            planes[k, 2] = planes[k - 1, 2]
            k -= 1
        planes[k, 0] = normal_n
        planes[k, 1] = normal_e
        planes[k, 2] = room
    for i in range(plane_count):
        farthest2 = 0.0
        for k in range(count):
            dn = corners[k, 0] - n
            de = corners[k, 1] - e
            farthest2 = max(farthest2, dn * dn + de * de)
        if planes[i, 2] > 0.0 and planes[i, 2] * planes[i, 2] >= farthest2:
            break
        count = _cut(corners, count, n, e, planes[i, 0], planes[i, 1], planes[i, 2], spare)
    return count


@compiled(_CELLS(_NUMBER, _NUMBER, _NUMBER, _NUMBER, _NUMBER, _NUMBER, _ROWS, _WHOLE, _ROWS, _ROWS, _ROWS))
def cells(
    own_n: float,
    own_e: float,
    evader_n: float,
    evader_e: float,
    half_n: float,
    half_e: float,
    planes: Array,
    plane_count: int,
    safety: Array,
    target: Array,
    spare: Array,
) -> Cells:
    """Both cells of the owner, with `half_n`, `half_e` the half sizes of the box around the evader.

    planes: (>= plane_count, 3), sorted on return. Into `safety` and `target` (plane_count + 9 rows, 2) go the corners; `spare`:
    room for as many.
    """
    dn = evader_n - own_n
    de = evader_e - own_e
    distance = math.hypot(dn, de)
    reach = distance + max(half_n, half_e) + ROOM_TO_SPARE_M
    count = _cut_by_planes(safety, _box(own_n, own_e, reach, reach, safety), own_n, own_e, planes, plane_count, spare)
    _, _, safety_area = centroid(safety, count)
    near_own_n, near_own_e = nearest_in(safety, count, own_n, own_e)
    for i in range(count):
        target[i, 0] = safety[i, 0]
        target[i, 1] = safety[i, 1]
    kept = count
    if distance > 1e-9:
        kept = _cut(target, kept, own_n, own_e, dn / distance, de / distance, 0.5 * distance, spare)
    near_evader_n, near_evader_e = nearest_in(target, kept, evader_n, evader_e)
    if kept == 0:
        near_evader_n, near_evader_e = near_own_n, near_own_e
    kept = _cut(target, kept, evader_n, evader_e, 1.0, 0.0, half_n, spare)
    kept = _cut(target, kept, evader_n, evader_e, -1.0, 0.0, half_n, spare)
    kept = _cut(target, kept, evader_n, evader_e, 0.0, 1.0, half_e, spare)
    kept = _cut(target, kept, evader_n, evader_e, 0.0, -1.0, half_e, spare)
    north, east, area = centroid(target, kept)
    return Cells(float(count), safety_area, float(kept), area, north, east, near_evader_n, near_evader_e, near_own_n, near_own_e)


class Dynamics(NamedTuple):
    """How fast the vehicle may near a half-plane; all floats."""

    speed_max_m_s: float
    period_s: float
    deceleration_m_s2: float
    """0: velocity-controlled, any velocity from one period to the next."""
    reaction_s: float
    leaving_gain_per_s: float
    leaving_speed_max_m_s: float


_DYNAMICS = numba.types.NamedUniTuple(numba.float64, len(Dynamics._fields), Dynamics)  # type: ignore[no-untyped-call]
_PAIR = numba.types.UniTuple(numba.float64, 2)  # type: ignore[no-untyped-call]


@compiled(_NUMBER(_NUMBER, _DYNAMICS))
def _speed_towards_m_s(room_m: float, dynamics: Dynamics) -> float:
    """Highest speed towards a half-plane `room_m` ahead; negative: lowest speed away from it."""
    d = dynamics
    if d.deceleration_m_s2 <= 0.0:
        return max(-d.speed_max_m_s, room_m / d.period_s)
    if room_m < 0.0:
        return max(-d.leaving_speed_max_m_s, room_m * d.leaving_gain_per_s)
    return braking_speed_m_s(room_m, d.deceleration_m_s2, d.reaction_s)


@compiled(_PAIR(_NUMBER, _NUMBER, _ROWS, _WHOLE, _DYNAMICS, _ROWS, _ROWS, _ROWS))
def held_velocity(
    wish_n: float, wish_e: float, planes: Array, plane_count: int, dynamics: Dynamics, speeds: Array, corners: Array, spare: Array
) -> tuple[float, float]:
    """The velocity (m/s) nearest to the wish that keeps to every half-plane, or leaves those that are violated.

    Velocity-controlled, that is the velocity whose straight way over one period ends in the safety cell. Where no velocity does,
    away from what is violated most. speeds: (>= plane_count, 3); corners, spare: (plane_count + 9, 2): room to work in.
    """
    away_n = 0.0
    away_e = 0.0
    for i in range(plane_count):
        speeds[i, 0] = planes[i, 0]
        speeds[i, 1] = planes[i, 1]
        speeds[i, 2] = _speed_towards_m_s(planes[i, 2], dynamics)
        away_n += min(0.0, planes[i, 2]) * planes[i, 0]
        away_e += min(0.0, planes[i, 2]) * planes[i, 1]
    speed_max = dynamics.speed_max_m_s
    count = _cut_by_planes(corners, _box(0.0, 0.0, speed_max, speed_max, corners), 0.0, 0.0, speeds, plane_count, spare)
    if count == 0:
        n = away_n / dynamics.period_s
        e = away_e / dynamics.period_s
    else:
        n, e = nearest_in(corners, count, wish_n, wish_e)
    speed = math.hypot(n, e)
    if speed > speed_max:
        n *= speed_max / speed
        e *= speed_max / speed
    return n, e

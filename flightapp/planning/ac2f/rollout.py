"""Roll-out of every candidate arc with its braking arc against moving discs: the hot kernel of the fine stage."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from flightapp.core.compiled import compiled
from flightapp.core.types import Array

ADMISSIBLE = 0
COLLISION = 1
BRAKING = 2


@compiled("f8(f8[:,::1],i8,f8,f8,f8,f8,f8)")
def segment_clearance_m(discs: Array, count: int, an: float, ae: float, bn: float, be: float, known_m: float) -> float:
    """Smallest distance to an edge of the first `count` discs on the way (an, ae) -> (bn, be).

    discs: (m, 5) north, east, radius at the start of the way, and the disc's own displacement north, east during it.
    `known_m` is a value that the caller already has: the result is never above it, and discs beyond it cost little.
    """
    best = known_m
    for i in range(count):
        rn = an - discs[i, 0]
        re = ae - discs[i, 1]
        dn = bn - an - discs[i, 3]
        de = be - ae - discs[i, 4]
        reach = best + discs[i, 2]
        if reach <= 0.0:
            continue
        start2 = rn * rn + re * re
        along2 = dn * dn + de * de
        # |start| - |along| >= reach, without roots: (reach + |along|)^2 <= 2 (reach^2 + |along|^2)
        if start2 >= 2.0 * (reach * reach + along2):
            continue
        fraction = 0.0
        if along2 > 0.0:
            fraction = min(1.0, max(0.0, -(rn * dn + re * de) / along2))
        rn += fraction * dn
        re += fraction * de
        gap2 = rn * rn + re * re
        if gap2 < reach * reach:
            best = math.sqrt(gap2) - discs[i, 2]
    return best


@compiled("f8(f8,f8,f8,f8)")
def _braking_way_m(v: float, deceleration_m_s2: float, reaction_s: float, t_s: float) -> float:
    """Way made `t_s` after the order to brake."""
    if t_s <= reaction_s:
        return v * t_s
    braked = t_s - reaction_s
    return v * t_s - 0.5 * deceleration_m_s2 * braked * braked


@compiled("void(f8[::1],f8[::1],f8[::1],f8,i8,f8[:,:,::1],f8[:,::1],f8[:,::1])")
def _arcs(start: Array, speeds: Array, turns: Array, step_s: float, steps: int, paths: Array, ends: Array, boxes: Array) -> None:
    """Fill paths and ends, and boxes (steps, 4: north from, to, east from, to) around all candidates in each step."""
    for k in range(steps):
        boxes[k, 0] = start[0] if k == 0 else 1e18
        boxes[k, 1] = start[0] if k == 0 else -1e18
        boxes[k, 2] = start[1] if k == 0 else 1e18
        boxes[k, 3] = start[1] if k == 0 else -1e18
    for c in range(speeds.shape[0]):
        v = speeds[c]
        w = turns[c]
        n = start[0]
        e = start[1]
        heading = start[2]
        step_n = v * step_s * math.cos(heading + 0.5 * w * step_s)
        step_e = v * step_s * math.sin(heading + 0.5 * w * step_s)
        cos = math.cos(w * step_s)
        sin = math.sin(w * step_s)
        for k in range(steps):
            n += step_n
            e += step_e
            heading += w * step_s
            turned_n = cos * step_n - sin * step_e
            step_e = sin * step_n + cos * step_e
            step_n = turned_n
            paths[c, k, 0] = n
            paths[c, k, 1] = e
            boxes[k, 0] = min(boxes[k, 0], n)
            boxes[k, 1] = max(boxes[k, 1], n)
            boxes[k, 2] = min(boxes[k, 2], e)
            boxes[k, 3] = max(boxes[k, 3], e)
        ends[c, 0] = n
        ends[c, 1] = e
        ends[c, 2] = heading
    for k in range(steps - 1, 0, -1):
        boxes[k, 0] = min(boxes[k, 0], boxes[k - 1, 0])
        boxes[k, 1] = max(boxes[k, 1], boxes[k - 1, 1])
        boxes[k, 2] = min(boxes[k, 2], boxes[k - 1, 2])
        boxes[k, 3] = max(boxes[k, 3], boxes[k - 1, 3])


@compiled("i8(f8[:,::1],f8,f8,f8[::1],f8,f8[:,::1])")
def _near(scene: Array, t_s: float, step_s: float, box: Array, range_m: float, out: Array) -> int:
    """Discs of `scene` (m, 6) whose edge comes within `range_m` of `box` (4,) between `t_s` and `t_s + step_s`.

    Fills out (m, 5) as `segment_clearance_m` takes it, and returns how many.
    """
    count = 0
    for i in range(scene.shape[0]):
        n = scene[i, 0] + scene[i, 3] * t_s
        e = scene[i, 1] + scene[i, 4] * t_s
        moved_n = scene[i, 3] * step_s
        moved_e = scene[i, 4] * step_s
        dn = max(0.0, box[0] - n - max(0.0, moved_n), n + min(0.0, moved_n) - box[1])
        de = max(0.0, box[2] - e - max(0.0, moved_e), e + min(0.0, moved_e) - box[3])
        reach = scene[i, 2] + range_m
        if dn * dn + de * de <= reach * reach:
            out[count, 0] = n
            out[count, 1] = e
            out[count, 2] = scene[i, 2]
            out[count, 3] = moved_n
            out[count, 4] = moved_e
            count += 1
    return count


@compiled("b1(f8,f8,f8,f8,f8)")
def _touches(rn: float, re: float, dn: float, de: float, radius_m: float) -> bool:
    """Whether the way from (rn, re) by (dn, de), both relative to the centre of a disc, touches the disc."""
    start2 = rn * rn + re * re
    radius2 = radius_m * radius_m
    along2 = dn * dn + de * de
    if start2 >= 2.0 * (radius2 + along2):
        return False
    fraction = 0.0
    if along2 > 0.0:
        fraction = min(1.0, max(0.0, -(rn * dn + re * de) / along2))
    rn += fraction * dn
    re += fraction * de
    return rn * rn + re * re <= radius2


@compiled("i8(f8[:,::1],i8,f8,f8,f8,f8)")
def _first_touched(discs: Array, count: int, an: float, ae: float, bn: float, be: float) -> int:
    """Index of the first of `discs` (m, 5) that the way (an, ae) -> (bn, be) touches; -1 for none."""
    for i in range(count):
        if _touches(an - discs[i, 0], ae - discs[i, 1], bn - an - discs[i, 3], be - ae - discs[i, 4], discs[i, 2]):
            return i
    return -1


@compiled("b1(f8[::1],f8[:,::1],f8)")
def _arc_touches(disc: Array, corners: Array, step_s: float) -> bool:
    """Whether `disc` (5,: displacement per second), moving from now on, touches the way along `corners` (k, 2)."""
    for k in range(corners.shape[0] - 1):
        t_s = k * step_s
        rn = corners[k, 0] - disc[0] - disc[3] * t_s
        re = corners[k, 1] - disc[1] - disc[4] * t_s
        dn = corners[k + 1, 0] - corners[k, 0] - disc[3] * step_s
        de = corners[k + 1, 1] - corners[k, 1] - disc[4] * step_s
        if _touches(rn, re, dn, de, disc[2]):
            return True
    return False


@compiled("b1(f8[::1],f8,f8,f8,f8)")
def _is_within(disc: Array, n: float, e: float, range_m: float, time_s: float) -> bool:
    """Whether `disc` (5,: displacement per second) could come within `range_m` of (n, e) during `time_s`."""
    dn = n - disc[0]
    de = e - disc[1]
    reach = disc[2] + range_m + time_s * (abs(disc[3]) + abs(disc[4]))
    return bool(dn * dn + de * de <= reach * reach)


@compiled("b1(f8[:,::1],i8,f8,f8,f8,f8)")
def _any_within(discs: Array, count: int, n: float, e: float, range_m: float, time_s: float) -> bool:
    """Whether one of the first `count` of `discs` could come within `range_m` of (n, e) during `time_s`."""
    near = False
    for i in range(count):
        near = near or _is_within(discs[i], n, e, range_m, time_s)
    return near


@compiled("i8(f8[:,::1],i8,i8,f8,f8,f8,f8,f8,f8,f8,f8[:,::1])")
def _braking_touches(
    near: Array,
    count: int,
    suspect: int,
    n: float,
    e: float,
    heading: float,
    v: float,
    w: float,
    deceleration_m_s2: float,
    reaction_s: float,
    corners: Array,
) -> int:
    """Index of a disc of `near` (m, 5: displacement per second) on the braking arc from (n, e, heading); -1 for none.

    `suspect` is tried first. corners: (braking steps + 1, 2), working space.
    """
    last = corners.shape[0] - 1
    middle = last // 2
    stop_s = reaction_s + v / deceleration_m_s2
    step_s = stop_s / last
    longest = _braking_way_m(v, deceleration_m_s2, reaction_s, stop_s)
    if not _any_within(near, count, n, e, longest, stop_s):
        return -1
    corners[0, 0] = n
    corners[0, 1] = e
    made = 0.0
    half = 0.0
    for k in range(last):
        after = _braking_way_m(v, deceleration_m_s2, reaction_s, k * step_s + step_s)
        way = after - made
        made = after
        turn = w * way / v
        n += way * math.cos(heading + 0.5 * turn)
        e += way * math.sin(heading + 0.5 * turn)
        heading += turn
        corners[k + 1, 0] = n
        corners[k + 1, 1] = e
        if k + 1 == middle:
            half = made
    if suspect < count and _arc_touches(near[suspect], corners, step_s):
        return suspect
    around = max(half, made - half)
    for i in range(count):
        if _is_within(near[i], corners[middle, 0], corners[middle, 1], around, stop_s) and _arc_touches(near[i], corners, step_s):
            return i
    return -1


@compiled("void(f8[::1],f8[::1],f8[::1],f8[:,::1],f8,i8,f8,f8,f8,i8,f8[:,:,::1],f8[:,::1],f8[::1],i8[::1])")
def roll_out(
    start: Array,
    speeds: Array,
    turns: Array,
    scene: Array,
    step_s: float,
    steps: int,
    saturation_m: float,
    deceleration_m_s2: float,
    reaction_s: float,
    braking_steps: int,
    paths: Array,
    ends: Array,
    clearances: Array,
    verdicts: NDArray[np.int64],
) -> None:
    """Fill paths (n, steps, 2), ends (n, 3: north, east, heading), clearances (n,) and verdicts (n,) for n candidates.

    start: (3,) north, east, heading. speeds, turns: (n,) m/s, rad/s. scene: (m, 6) inflated moving discs. A candidate is
    rejected when its arc touches a disc, or when the same arc, held for `reaction_s` and then braked, does.
    """
    boxes = np.empty((steps, 4))
    _arcs(start, speeds, turns, step_s, steps, paths, ends, boxes)
    near = np.empty((steps, scene.shape[0], 5))
    counts = np.empty(steps, np.int64)
    for k in range(steps):
        counts[k] = _near(scene, k * step_s, step_s, boxes[k], saturation_m, near[k])
    fastest = 0.0
    for c in range(speeds.shape[0]):
        fastest = max(fastest, speeds[c])
    stop_s = reaction_s + fastest / deceleration_m_s2
    longest = _braking_way_m(fastest, deceleration_m_s2, reaction_s, stop_s) + 1e-3
    ahead = np.empty((scene.shape[0], 5))
    ahead_count = _near(scene, steps * step_s, stop_s, boxes[steps - 1], longest, ahead)
    for i in range(ahead_count):
        ahead[i, 3] /= stop_s
        ahead[i, 4] /= stop_s
    corners = np.empty((braking_steps + 1, 2))
    blocked_step = 0
    blocker = 0
    brake_blocker = 0
    for c in range(speeds.shape[0]):
        n = start[0] if blocked_step == 0 else paths[c, blocked_step - 1, 0]
        e = start[1] if blocked_step == 0 else paths[c, blocked_step - 1, 1]
        verdicts[c] = 1
        clearances[c] = 0.0
        if blocker < counts[blocked_step] and (
            _first_touched(
                near[blocked_step, blocker : blocker + 1], 1, n, e, paths[c, blocked_step, 0], paths[c, blocked_step, 1]
            )
            == 0
        ):
            continue
        n = start[0]
        e = start[1]
        clearance = saturation_m
        for k in range(steps):
            next_n = paths[c, k, 0]
            next_e = paths[c, k, 1]
            clearance = segment_clearance_m(near[k], counts[k], n, e, next_n, next_e, clearance)
            if clearance <= 0.0:
                blocked_step = k
                blocker = max(0, _first_touched(near[k], counts[k], n, e, next_n, next_e))
                break
            n = next_n
            e = next_e
        clearances[c] = clearance
        if clearance > 0.0:
            verdicts[c] = 0
            if speeds[c] > 0.0:
                found = _braking_touches(
                    ahead,
                    ahead_count,
                    brake_blocker,
                    n,
                    e,
                    ends[c, 2],
                    speeds[c],
                    turns[c],
                    deceleration_m_s2,
                    reaction_s,
                    corners,
                )
                if found >= 0:
                    brake_blocker = found
                    verdicts[c] = 2

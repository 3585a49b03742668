"""Every candidate of the dynamic window rolled out, with its braking arc, against moving discs: the fine stage's hot kernel.

Arrays have the candidate innermost, and work goes by blocks of neighbouring candidates: one disc against a whole block is one
loop without branches. Discs that cannot matter for a block are left out beforehand, by a circle around all of its candidates.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.ac2f.elementary import sin_cos

ADMISSIBLE = 0
COLLISION = 1
BRAKING = 2
BLOCK = 64
ROUNDING_M = 1e-9  # what the pruning allows for rounding


@compiled("void(f8[::1],f8[::1],f8[::1],f8[::1],f8[::1],f8[::1],f8[::1],f8[::1])")
def _advance(
    from_n: Array, from_e: Array, turn_cos: Array, turn_sin: Array, step_n: Array, step_e: Array, to_n: Array, to_e: Array
) -> None:
    """One step of all candidates, and the next step's chord in its place."""
    for c in range(from_n.shape[0]):
        to_n[c] = from_n[c] + step_n[c]
        to_e[c] = from_e[c] + step_e[c]
        turned_n = turn_cos[c] * step_n[c] - turn_sin[c] * step_e[c]
        step_e[c] = turn_sin[c] * step_n[c] + turn_cos[c] * step_e[c]
        step_n[c] = turned_n


@compiled("void(f8,f8,f8,f8[::1],f8[::1],f8,f8[:,::1],f8[:,::1],f8[::1],f8[::1])")
def roll_out(
    start_n: float,
    start_e: float,
    course_rad: float,
    speeds: Array,
    turns: Array,
    step_s: float,
    north: Array,
    east: Array,
    cosines: Array,
    sines: Array,
) -> None:
    """Fill north, east (steps + 1, n): positions in m, the start first; cosines, sines (n,): direction at the end.

    speeds, turns (n,) in m/s, rad/s. Each step is the chord in the direction of its middle heading.
    """
    course_sin, course_cos = sin_cos(course_rad)
    count = speeds.shape[0]
    turn_cos = np.empty(count)
    turn_sin = np.empty(count)
    step_n = np.empty(count)
    step_e = np.empty(count)
    for c in range(count):
        half_sin, half_cos = sin_cos(0.5 * turns[c] * step_s)
        way = speeds[c] * step_s
        step_n[c] = way * (course_cos * half_cos - course_sin * half_sin)
        step_e[c] = way * (course_sin * half_cos + course_cos * half_sin)
        turn_cos[c] = half_cos * half_cos - half_sin * half_sin
        turn_sin[c] = 2.0 * half_sin * half_cos
    north[0] = start_n
    east[0] = start_e
    for k in range(1, north.shape[0]):
        _advance(north[k - 1], east[k - 1], turn_cos, turn_sin, step_n, step_e, north[k], east[k])
    time_s = (north.shape[0] - 1) * step_s
    for c in range(count):
        sine, cosine = sin_cos(course_rad + turns[c] * time_s)
        cosines[c] = cosine
        sines[c] = sine


@compiled("i8(f8[::1],f8[::1],f8[::1],f8[::1],f8[::1],f8,f8,f8,f8[::1])")
def _count_nearer(
    from_n: Array,
    from_e: Array,
    way_n: Array,
    way_e: Array,
    inverse2: Array,
    disc_n: float,
    disc_e: float,
    radius_m: float,
    clearances: Array,
) -> int:
    """How many candidates come nearer to a disc than their clearance so far; ways relative to it, inverse2 = 1 / way^2."""
    count = 0
    for c in range(clearances.shape[0]):
        rn = from_n[c] - disc_n
        re = from_e[c] - disc_e
        fraction = -(rn * way_n[c] + re * way_e[c]) * inverse2[c]
        fraction = fraction if fraction > 0.0 else 0.0
        fraction = fraction if fraction < 1.0 else 1.0
        rn += fraction * way_n[c]
        re += fraction * way_e[c]
        reach = clearances[c] + radius_m
        count += 1 if rn * rn + re * re < reach * reach else 0
    return count


@compiled("void(f8[::1],f8[::1],f8[::1],f8[::1],f8[::1],f8,f8,f8,f8[::1])")
def _lower(
    from_n: Array,
    from_e: Array,
    way_n: Array,
    way_e: Array,
    inverse2: Array,
    disc_n: float,
    disc_e: float,
    radius_m: float,
    clearances: Array,
) -> None:
    """Lower the clearances of candidates that come nearer to a disc; arguments as for `_count_nearer`."""
    for c in range(clearances.shape[0]):
        rn = from_n[c] - disc_n
        re = from_e[c] - disc_e
        fraction = -(rn * way_n[c] + re * way_e[c]) * inverse2[c]
        fraction = fraction if fraction > 0.0 else 0.0
        fraction = fraction if fraction < 1.0 else 1.0
        rn += fraction * way_n[c]
        re += fraction * way_e[c]
        gap = math.sqrt(rn * rn + re * re) - radius_m
        clearances[c] = gap if gap < clearances[c] else clearances[c]


@compiled("void(f8[::1],f8[::1],f8[::1],f8[::1],f8[::1],f8,f8,f8,f8[::1],i8[::1])")
def _reject_touching(
    from_n: Array,
    from_e: Array,
    way_n: Array,
    way_e: Array,
    inverse2: Array,
    disc_n: float,
    disc_e: float,
    radius_m: float,
    speeds: Array,
    verdicts: NDArray[np.int64],
) -> None:
    """BRAKING for the admissible moving candidates that touch a disc; arguments as for `_count_nearer`."""
    radius2 = radius_m * radius_m
    for c in range(verdicts.shape[0]):
        rn = from_n[c] - disc_n
        re = from_e[c] - disc_e
        fraction = -(rn * way_n[c] + re * way_e[c]) * inverse2[c]
        fraction = fraction if fraction > 0.0 else 0.0
        fraction = fraction if fraction < 1.0 else 1.0
        rn += fraction * way_n[c]
        re += fraction * way_e[c]
        touches = (rn * rn + re * re <= radius2) & (speeds[c] > 0.0) & (verdicts[c] == ADMISSIBLE)
        verdicts[c] = BRAKING if touches else verdicts[c]


@compiled("void(f8[::1],f8[::1],f8[::1])")
def _invert_squares(way_n: Array, way_e: Array, inverse2: Array) -> None:
    for c in range(inverse2.shape[0]):
        way2 = way_n[c] * way_n[c] + way_e[c] * way_e[c]
        inverse2[c] = 1.0 / (way2 if way2 > 0.0 else 1.0)


@compiled("void(f8[::1],f8[::1],f8[::1])")
def _subtract(a: Array, b: Array, out: Array) -> None:
    for c in range(out.shape[0]):
        out[c] = a[c] - b[c]


@compiled("void(f8[::1],f8,f8[::1])")
def _subtract_constant(a: Array, b: float, out: Array) -> None:
    for c in range(out.shape[0]):
        out[c] = a[c] - b


@compiled("void(f8[::1],f8,f8[::1],f8[::1])")
def _subtract_drift(a: Array, drift: float, times: Array, out: Array) -> None:
    for c in range(out.shape[0]):
        out[c] = a[c] - drift * times[c]


@compiled("f8(f8[::1])")
def _largest(values: Array) -> float:
    """The largest of `values`; four at a time, because one after the other each comparison waits for the last."""
    a = values[0]
    b = a
    c = a
    d = a
    whole = values.shape[0] - values.shape[0] % 4
    for i in range(0, whole, 4):
        a = values[i] if values[i] > a else a
        b = values[i + 1] if values[i + 1] > b else b
        c = values[i + 2] if values[i + 2] > c else c
        d = values[i + 3] if values[i + 3] > d else d
    for i in range(whole, values.shape[0]):
        a = values[i] if values[i] > a else a
    a = b if b > a else a
    c = d if d > c else c
    largest: float = c if c > a else a
    return largest


@compiled("f8(f8[::1],f8[::1],i8,f8[::1])")
def _spread_m(north: Array, east: Array, middle: int, scratch: Array) -> float:
    """Radius of the circle around candidate `middle` that holds all others."""
    middle_n = north[middle]
    middle_e = east[middle]
    for c in range(north.shape[0]):
        dn = north[c] - middle_n
        de = east[c] - middle_e
        scratch[c] = dn * dn + de * de
    return math.sqrt(_largest(scratch[: north.shape[0]]))


@compiled("f8(f8,f8,f8,f8)")
def _segment2(rn: float, re: float, dn: float, de: float) -> float:
    """Squared distance of the origin from the segment that starts at (rn, re) and goes by (dn, de)."""
    along2 = dn * dn + de * de
    fraction = -(rn * dn + re * de) / (along2 if along2 > 0.0 else 1.0)
    fraction = fraction if fraction > 0.0 else 0.0
    fraction = fraction if fraction < 1.0 else 1.0
    rn += fraction * dn
    re += fraction * de
    distance2: float = rn * rn + re * re
    return distance2


@compiled("i8(f8[:,::1],f8[:,::1],f8[:,::1],i8,f8[::1],f8,f8,f8,i8[::1])")
def _select(
    scene: Array,
    north: Array,
    east: Array,
    middle: int,
    spreads: Array,
    range_m: float,
    from_s: float,
    until_s: float,
    out: NDArray[np.int64],
) -> int:
    """Fill out with the discs that come within `range_m` of a block's ways between two times; returns how many."""
    half = north.shape[0] // 2
    centre_n = north[half, middle]
    centre_e = east[half, middle]
    radius = 0.0
    for k in range(north.shape[0]):
        here = math.hypot(north[k, middle] - centre_n, east[k, middle] - centre_e) + spreads[k]
        radius = here if here > radius else radius
    count = 0
    for i in range(scene.shape[0]):
        rn = centre_n - scene[i, 0] - scene[i, 3] * from_s
        re = centre_e - scene[i, 1] - scene[i, 4] * from_s
        drift = (abs(scene[i, 3]) + abs(scene[i, 4])) * (until_s - from_s)
        reach = radius + range_m + scene[i, 2] + drift + ROUNDING_M
        if rn * rn + re * re <= reach * reach:
            out[count] = i
            count += 1
    return count


@compiled("void(f8[:,::1],f8,f8,f8[:,::1],f8[:,::1],i8,f8[::1],f8[:,::1],f8[::1],i8[::1])")
def _clear_block(
    scene: Array,
    step_s: float,
    saturation_m: float,
    north: Array,
    east: Array,
    low: int,
    clearances: Array,
    scratch: Array,
    spreads: Array,
    near: NDArray[np.int64],
) -> None:
    """Fill the clearances (block,) of the candidates from `low` on."""
    size = clearances.shape[0]
    high = low + size
    steps = north.shape[0] - 1
    middle = low + size // 2
    way_n = scratch[0, :size]
    way_e = scratch[1, :size]
    inverse2 = scratch[2, :size]
    relative_n = scratch[3, :size]
    relative_e = scratch[4, :size]
    relative2 = scratch[5, :size]
    clearances[:] = saturation_m
    for k in range(steps + 1):
        spreads[k] = _spread_m(north[k, low:high], east[k, low:high], size // 2, relative2)
    count = _select(scene, north, east, middle, spreads[: steps + 1], saturation_m, 0.0, steps * step_s, near)
    worst = saturation_m
    for k in range(steps):
        from_n = north[k, low:high]
        from_e = east[k, low:high]
        middle_n = north[k, middle]
        middle_e = east[k, middle]
        middle_way_n = north[k + 1, middle] - middle_n
        middle_way_e = east[k + 1, middle] - middle_e
        spread = max(spreads[k], spreads[k + 1])
        filled = False
        changed = False
        for j in range(count):
            i = near[j]
            disc_n = scene[i, 0] + scene[i, 3] * (k * step_s)
            disc_e = scene[i, 1] + scene[i, 4] * (k * step_s)
            moved_n = scene[i, 3] * step_s
            moved_e = scene[i, 4] * step_s
            reach = scene[i, 2] + worst + spread + ROUNDING_M
            away2 = _segment2(middle_n - disc_n, middle_e - disc_e, middle_way_n - moved_n, middle_way_e - moved_e)
            if away2 > reach * reach:
                continue
            if not filled:
                _subtract(north[k + 1, low:high], from_n, way_n)
                _subtract(east[k + 1, low:high], from_e, way_e)
                _invert_squares(way_n, way_e, inverse2)
                filled = True
            if moved_n == 0.0 and moved_e == 0.0:
                if _count_nearer(from_n, from_e, way_n, way_e, inverse2, disc_n, disc_e, scene[i, 2], clearances) > 0:
                    _lower(from_n, from_e, way_n, way_e, inverse2, disc_n, disc_e, scene[i, 2], clearances)
                    changed = True
            else:
                _subtract_constant(way_n, moved_n, relative_n)
                _subtract_constant(way_e, moved_e, relative_e)
                _invert_squares(relative_n, relative_e, relative2)
                if _count_nearer(from_n, from_e, relative_n, relative_e, relative2, disc_n, disc_e, scene[i, 2], clearances) > 0:
                    _lower(from_n, from_e, relative_n, relative_e, relative2, disc_n, disc_e, scene[i, 2], clearances)
                    changed = True
        if changed:
            worst = _largest(clearances)
            if worst <= 0.0:
                return


@compiled("void(f8[::1],f8[::1],f8[::1],f8[::1],f8,f8,f8,f8[::1],f8[::1],f8[::1],f8[::1],f8[::1],f8[::1])")
def _brake(
    speeds: Array,
    turns: Array,
    cosines: Array,
    sines: Array,
    deceleration_m_s2: float,
    reaction_s: float,
    share: float,
    stops: Array,
    made: Array,
    from_n: Array,
    from_e: Array,
    to_n: Array,
    to_e: Array,
) -> None:
    """The next chord of all braking arcs, until `share` of the time to stop; made: way so far (m)."""
    for c in range(speeds.shape[0]):
        t_s = share * stops[c]
        braked_s = t_s - reaction_s
        braked_s = braked_s if braked_s > 0.0 else 0.0
        after = speeds[c] * t_s - 0.5 * deceleration_m_s2 * braked_s * braked_s
        curvature = turns[c] / (speeds[c] if speeds[c] > 0.0 else 1.0)
        sine, cosine = sin_cos(0.5 * curvature * (made[c] + after))
        way = after - made[c]
        to_n[c] = from_n[c] + way * (cosines[c] * cosine - sines[c] * sine)
        to_e[c] = from_e[c] + way * (sines[c] * cosine + cosines[c] * sine)
        made[c] = after


@compiled("void(f8[::1],f8[::1],f8[::1],f8[::1],f8,f8,f8[:,::1],f8[:,::1],f8[::1],f8[::1])")
def _roll_out_braking(
    speeds: Array,
    turns: Array,
    cosines: Array,
    sines: Array,
    deceleration_m_s2: float,
    reaction_s: float,
    north: Array,
    east: Array,
    made: Array,
    stops: Array,
) -> None:
    """Fill north, east (braking steps + 1, block) after row 0, and stops: time (s) from the order to brake until standing."""
    size = speeds.shape[0]
    last = north.shape[0] - 1
    for c in range(size):
        stops[c] = reaction_s + speeds[c] / deceleration_m_s2
        made[c] = 0.0
    for k in range(last):
        share = (k + 1.0) / last
        from_n = north[k, :size]
        from_e = east[k, :size]
        to_n = north[k + 1, :size]
        to_e = east[k + 1, :size]
        _brake(speeds, turns, cosines, sines, deceleration_m_s2, reaction_s, share, stops, made, from_n, from_e, to_n, to_e)


@compiled("void(f8[:,::1],f8[::1],f8,f8[::1],f8[:,::1],f8[:,::1],i8[::1],f8[:,::1],f8[::1],i8[::1])")
def _brake_block(
    scene: Array,
    speeds: Array,
    from_s: float,
    stops: Array,
    north: Array,
    east: Array,
    verdicts: NDArray[np.int64],
    scratch: Array,
    spreads: Array,
    near: NDArray[np.int64],
) -> None:
    """Reject the candidates of one block whose braking arc, north, east (braking steps + 1, block), touches a disc."""
    size = speeds.shape[0]
    last = north.shape[0] - 1
    middle = size // 2
    way_n = scratch[0, :size]
    way_e = scratch[1, :size]
    inverse2 = scratch[2, :size]
    relative_n = scratch[3, :size]
    relative_e = scratch[4, :size]
    start_n = scratch[5, :size]
    start_e = scratch[6, :size]
    relative2 = scratch[7, :size]
    for k in range(last + 1):
        spreads[k] = _spread_m(north[k, :size], east[k, :size], middle, relative2)
    longest = _largest(stops)
    count = _select(scene, north, east, middle, spreads[: last + 1], 0.0, from_s, from_s + longest, near)
    if count == 0:
        return
    for c in range(size):
        relative2[c] = abs(stops[c] - stops[middle])
    differing = _largest(relative2)
    step_s = stops[middle] / last
    for k in range(last):
        from_n = north[k, :size]
        from_e = east[k, :size]
        middle_n = north[k, middle]
        middle_e = east[k, middle]
        middle_way_n = north[k + 1, middle] - middle_n
        middle_way_e = east[k + 1, middle] - middle_e
        spread = max(spreads[k], spreads[k + 1])
        filled = False
        for j in range(count):
            i = near[j]
            t_s = from_s + k * step_s
            disc_n = scene[i, 0] + scene[i, 3] * t_s
            disc_e = scene[i, 1] + scene[i, 4] * t_s
            drift = (abs(scene[i, 3]) + abs(scene[i, 4])) * differing
            reach = scene[i, 2] + spread + drift + ROUNDING_M
            away2 = _segment2(
                middle_n - disc_n, middle_e - disc_e, middle_way_n - scene[i, 3] * step_s, middle_way_e - scene[i, 4] * step_s
            )
            if away2 > reach * reach:
                continue
            if not filled:
                _subtract(north[k + 1, :size], from_n, way_n)
                _subtract(east[k + 1, :size], from_e, way_e)
                _invert_squares(way_n, way_e, inverse2)
                filled = True
            if scene[i, 3] == 0.0 and scene[i, 4] == 0.0:
                _reject_touching(from_n, from_e, way_n, way_e, inverse2, scene[i, 0], scene[i, 1], scene[i, 2], speeds, verdicts)
            else:
                _subtract_drift(way_n, scene[i, 3] / last, stops, relative_n)
                _subtract_drift(way_e, scene[i, 4] / last, stops, relative_e)
                _invert_squares(relative_n, relative_e, relative2)
                _subtract_drift(from_n, scene[i, 3] * k / last, stops, start_n)
                _subtract_drift(from_e, scene[i, 4] * k / last, stops, start_e)
                disc_n = scene[i, 0] + scene[i, 3] * from_s
                disc_e = scene[i, 1] + scene[i, 4] * from_s
                _reject_touching(
                    start_n, start_e, relative_n, relative_e, relative2, disc_n, disc_e, scene[i, 2], speeds, verdicts
                )


@compiled("b1(f8[:,::1],f8,f8,f8,f8,f8)")
def _any_within(scene: Array, n: float, e: float, range_m: float, from_s: float, until_s: float) -> bool:
    """Whether a disc comes within `range_m` of (n, e) between two times."""
    for i in range(scene.shape[0]):
        rn = n - scene[i, 0] - scene[i, 3] * from_s
        re = e - scene[i, 1] - scene[i, 4] * from_s
        reach = range_m + scene[i, 2] + (abs(scene[i, 3]) + abs(scene[i, 4])) * (until_s - from_s) + ROUNDING_M
        if rn * rn + re * re <= reach * reach:
            return True
    return False


@compiled(
    "void(f8[:,::1],f8[::1],f8[::1],f8,f8,f8,f8,i8,b1,f8[:,::1],f8[:,::1],f8[::1],f8[::1],f8[::1],i8[::1])",
)
def sweep(
    scene: Array,
    speeds: Array,
    turns: Array,
    step_s: float,
    saturation_m: float,
    deceleration_m_s2: float,
    reaction_s: float,
    braking_steps: int,
    admissibility: bool,
    north: Array,
    east: Array,
    cosines: Array,
    sines: Array,
    clearances: Array,
    verdicts: NDArray[np.int64],
) -> None:
    """Fill clearances (n,) in m, at most `saturation_m`, and verdicts (n,) of the candidates that `roll_out` laid out.

    scene: (m, 6) inflated moving discs. COLLISION: the way touches a disc; the clearance is then at most 0 and no more than
    that. BRAKING, with `admissibility`: the same arc, held for `reaction_s` and then braked to a stop, does.
    """
    steps = north.shape[0] - 1
    near = np.empty(scene.shape[0], np.int64)
    scratch = np.empty((10, BLOCK))
    spreads = np.empty(max(steps, braking_steps) + 1)
    corners_n = np.empty((braking_steps + 1, BLOCK))
    corners_e = np.empty((braking_steps + 1, BLOCK))
    for low in range(0, speeds.shape[0], BLOCK):
        high = min(low + BLOCK, speeds.shape[0])
        size = high - low
        _clear_block(scene, step_s, saturation_m, north, east, low, clearances[low:high], scratch, spreads, near)
        free = 0
        for c in range(low, high):
            verdicts[c] = ADMISSIBLE if clearances[c] > 0.0 else COLLISION
            free += 1 if clearances[c] > 0.0 else 0
        if free == 0 or not admissibility:
            continue
        for c in range(size):
            corners_n[0, c] = north[steps, low + c]
            corners_e[0, c] = east[steps, low + c]
        middle = low + size // 2
        fastest = _largest(speeds[low:high])
        longest_s = reaction_s + fastest / deceleration_m_s2
        longest_m = fastest * reaction_s + 0.5 * fastest * fastest / deceleration_m_s2
        range_m = longest_m + _spread_m(north[steps, low:high], east[steps, low:high], size // 2, scratch[0])
        from_s = steps * step_s
        if not _any_within(scene, north[steps, middle], east[steps, middle], range_m, from_s, from_s + longest_s):
            continue
        stops = scratch[8, :size]
        made = scratch[9, :size]
        block_speeds = speeds[low:high]
        _roll_out_braking(
            block_speeds,
            turns[low:high],
            cosines[low:high],
            sines[low:high],
            deceleration_m_s2,
            reaction_s,
            corners_n,
            corners_e,
            made,
            stops,
        )
        _brake_block(scene, block_speeds, steps * step_s, stops, corners_n, corners_e, verdicts[low:high], scratch, spreads, near)

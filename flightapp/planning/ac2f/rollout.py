"""Roll-out of every candidate arc with its braking arc against moving discs: the hot kernel of the fine stage."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from flightapp.core.types import Array
from flightapp.planning.compiled import compiled

ADMISSIBLE = 0
COLLISION = 1
BRAKING = 2


@compiled("f8(f8[:,::1],f8,f8,f8,f8,f8,f8,f8)")
def segment_clearance_m(
    scene: Array, t_s: float, step_s: float, an: float, ae: float, bn: float, be: float, known_m: float
) -> float:
    """Smallest distance to an edge of `scene` (m, 6) on the way (an, ae) -> (bn, be) between `t_s` and `t_s + step_s`.

    `known_m` is a value that the caller already has: the result is never above it, and discs beyond it cost little.
    """
    best = known_m
    for i in range(scene.shape[0]):
        rn = an - scene[i, 0] - scene[i, 3] * t_s
        re = ae - scene[i, 1] - scene[i, 4] * t_s
        dn = bn - an - scene[i, 3] * step_s
        de = be - ae - scene[i, 4] * step_s
        start2 = rn * rn + re * re
        reach = best + scene[i, 2]
        if reach <= 0.0:
            continue
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
            best = math.sqrt(gap2) - scene[i, 2]
    return best


@compiled("f8(f8,f8,f8,f8)")
def _braking_way_m(v: float, deceleration_m_s2: float, reaction_s: float, t_s: float) -> float:
    """Way made `t_s` after the order to brake."""
    if t_s <= reaction_s:
        return v * t_s
    braked = t_s - reaction_s
    return v * t_s - 0.5 * deceleration_m_s2 * braked * braked


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
    for c in range(speeds.shape[0]):
        v = speeds[c]
        w = turns[c]
        n = start[0]
        e = start[1]
        heading = start[2]
        clearance = saturation_m
        verdict = 0
        step_n = v * step_s * math.cos(heading + 0.5 * w * step_s)
        step_e = v * step_s * math.sin(heading + 0.5 * w * step_s)
        cos = math.cos(w * step_s)
        sin = math.sin(w * step_s)
        for k in range(steps):
            next_n = n + step_n
            next_e = e + step_e
            clearance = segment_clearance_m(scene, k * step_s, step_s, n, e, next_n, next_e, clearance)
            n = next_n
            e = next_e
            heading += w * step_s
            turned_n = cos * step_n - sin * step_e
            step_e = sin * step_n + cos * step_e
            step_n = turned_n
            paths[c, k, 0] = n
            paths[c, k, 1] = e
            if clearance <= 0.0:
                verdict = 1
                break
        ends[c, 0] = n
        ends[c, 1] = e
        ends[c, 2] = heading
        clearances[c] = clearance
        if verdict == 0 and v > 0.0:
            gap = 1e-3
            t = steps * step_s
            stop_s = reaction_s + v / deceleration_m_s2
            brake_step = stop_s / braking_steps
            for k in range(braking_steps):
                t0 = k * brake_step
                t1 = t0 + brake_step
                way = _braking_way_m(v, deceleration_m_s2, reaction_s, t1) - _braking_way_m(v, deceleration_m_s2, reaction_s, t0)
                turn = w * way / v
                middle = heading + 0.5 * turn
                next_n = n + way * math.cos(middle)
                next_e = e + way * math.sin(middle)
                gap = segment_clearance_m(scene, t + t0, brake_step, n, e, next_n, next_e, gap)
                n = next_n
                e = next_e
                heading += turn
                if gap <= 0.0:
                    verdict = 2
                    break
        verdicts[c] = verdict

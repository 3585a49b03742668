"""Memory: how much a candidate revisits where the vehicle has just been."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from flightapp.core.compiled import compiled
from flightapp.core.types import Array


@compiled("f8(f8)")
def _exp(x: float) -> float:
    """exp(x) for -4.5 <= x <= 0 within 1e-10, in arithmetic that runs over several points at a time: exp(x / 32) ** 32."""
    y = x * 0.03125
    power = 1.0 + y * (1.0 + y * (1 / 2 + y * (1 / 6 + y * (1 / 24 + y * (1 / 120 + y * (1 / 720 + y * (1 / 5040)))))))
    power *= power
    power *= power
    power *= power
    power *= power
    return power * power


@compiled("f8(f8)")
def _wide_exp(x: float) -> float:
    """exp(x) for -100 <= x <= 100 within 1e-9 of its value, and within 1e-12 for -20 <= x <= 20: exp(x / 1024) ** 1024."""
    y = x * (1.0 / 1024.0)
    power = 1.0 + y * (1.0 + y * (1 / 2 + y * (1 / 6 + y * (1 / 24 + y * (1 / 120 + y * (1 / 720 + y * (1 / 5040)))))))
    power *= power
    power *= power
    power *= power
    power *= power
    power *= power
    power *= power
    power *= power
    power *= power
    power *= power
    return power * power


@compiled("void(f8,f8,f8[::1],f8[::1],f8,f8,f8[::1])")
def _add_one(n: float, e: float, past_n: Array, past_e: Array, factor: float, reach2: float, sums: Array) -> None:
    """Add the penalty of the point (n, e) for each past position to its sum."""
    for h in range(sums.shape[0]):
        dn = n - past_n[h]
        de = e - past_e[h]
        distance2 = dn * dn + de * de
        within = distance2 if distance2 < reach2 else reach2
        penalty = _exp(factor * within)
        sums[h] += penalty if distance2 < reach2 else 0.0


@compiled("void(f8,f8,f8,f8,f8[::1],f8[::1],f8,f8,f8[::1],f8[::1])")
def _start_row(
    n: float,
    e: float,
    step_n: float,
    step_e: float,
    past_n: Array,
    past_e: Array,
    factor: float,
    range2: float,
    x: Array,
    ratio: Array,
) -> None:
    """Penalties x of (n, e), and the ratios to what they are one step further, but for what all past positions share."""
    for h in range(x.shape[0]):
        dn = n - past_n[h]
        de = e - past_e[h]
        distance2 = dn * dn + de * de
        far = distance2 > range2
        ratio[h] = _wide_exp(0.0 if far else 2.0 * factor * (dn * step_n + de * step_e))
        x[h] = 0.0 if far else _wide_exp(0.0 if far else factor * distance2)


@compiled("void(f8[::1],f8[::1],f8[::1],f8,f8[:,::1])")
def _add_row(x: Array, ratio: Array, shares: Array, least: float, sums: Array) -> None:
    """Add the penalties of a row of points, three at a time, to their sums (row, past positions); x moves on behind them."""
    for i in range(0, shares.shape[0], 3):
        share_a = shares[i]
        share_b = shares[i + 1]
        share_c = shares[i + 2]
        for h in range(x.shape[0]):
            at_a = x[h]
            at_b = at_a * ratio[h]
            at_c = at_b * ratio[h]
            x[h] = at_c * ratio[h]
            at_a *= share_a
            at_b *= share_b
            at_c *= share_c
            sums[i, h] += at_a if at_a > least else 0.0
            sums[i + 1, h] += at_b if at_b > least else 0.0
            sums[i + 2, h] += at_c if at_c > least else 0.0


@compiled("b1(f8[::1],f8[::1],i8,i8,f8)")
def _is_even(north: Array, east: Array, low: int, high: int, tolerance_m: float) -> bool:
    """Whether the points low ... high - 1 lie on a straight line at equal distances."""
    last = high - low - 1
    step_n = (north[high - 1] - north[low]) / last
    step_e = (east[high - 1] - east[low]) / last
    worst = 0.0
    for i in range(1, last):
        worst = max(worst, abs(north[low + i] - north[low] - i * step_n), abs(east[low + i] - east[low] - i * step_e))
    return worst <= tolerance_m


@compiled("void(f8[:,::1],f8[:,::1],f8[:,::1],f8,i8,i8[::1],f8[::1])")
def memory_score(
    north: Array, east: Array, history: Array, scale_m: float, row: int, verdicts: NDArray[np.int64], out: Array
) -> None:
    """Fill out (n,): sum of exp(-d^2 / (2 scale^2)) over the points of each path and the history; a penalty.

    north, east (points, n) and history (h, 2) in m; the kernel is cut off at three scales. Candidates come in rows of `row`;
    rows without an admissible candidate (verdict 0) get 0. Where the candidates of a row are spread evenly along a line, as
    those with one turn rate are, the kernel is a product along the row and needs no exponential for each of them.
    """
    lanes = 8 * ((history.shape[0] + 7) // 8)
    past_n = np.full(lanes, 1e9)
    past_e = np.full(lanes, 1e9)
    for h in range(history.shape[0]):
        past_n[h] = history[h, 0]
        past_e[h] = history[h, 1]
    x = np.empty(lanes)
    ratio = np.empty(lanes)
    rows = 3 * ((row + 2) // 3)
    sums = np.empty((rows, lanes))
    shares = np.zeros(rows)
    reach = 3.0 * scale_m
    factor = -0.5 / (scale_m * scale_m)
    least = math.exp(-4.5)
    last = north.shape[0] - 1
    for low in range(0, out.shape[0], row):
        high = low + row
        free = False
        for c in range(low, high):
            out[c] = 0.0
            free = free or verdicts[c] == 0
        if not free:
            continue
        sums[:] = 0.0
        length = math.hypot(north[last, high - 1] - north[last, low], east[last, high - 1] - east[last, low])
        even = row > 1 and length < 5.0 * scale_m and _is_even(north[last], east[last], low, high, 1e-12)
        for k in range(north.shape[0]):
            if not even:
                for i in range(row):
                    if verdicts[low + i] == 0:
                        _add_one(north[k, low + i], east[k, low + i], past_n, past_e, factor, reach * reach, sums[i])
                continue
            step_n = (north[k, high - 1] - north[k, low]) / (row - 1)
            step_e = (east[k, high - 1] - east[k, low]) / (row - 1)
            away = reach + math.sqrt(step_n * step_n + step_e * step_e) * row
            _start_row(north[k, low], east[k, low], step_n, step_e, past_n, past_e, factor, away * away, x, ratio)
            step_share = math.exp(factor * (step_n * step_n + step_e * step_e))
            share = 1.0
            growth = step_share
            for i in range(row):
                shares[i] = share
                share *= growth
                growth *= step_share * step_share
            _add_row(x, ratio, shares, least, sums)
        for i in range(row):
            total = 0.0
            for h in range(0, lanes, 8):
                left = (sums[i, h] + sums[i, h + 1]) + (sums[i, h + 2] + sums[i, h + 3])
                right = (sums[i, h + 4] + sums[i, h + 5]) + (sums[i, h + 6] + sums[i, h + 7])
                total += left + right
            out[low + i] = total

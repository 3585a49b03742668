"""When pursuers can be at places that move with the evader, with what a way around obstacles costs."""

from __future__ import annotations

import numpy as np

from flightapp.core.types import Array

DETOUR_SHARE_MAX = 1.0
"""Of the straight way: a detour's estimate from single discs says nothing beyond."""


def arrival_times_s(starts: Array, speeds_m_s: Array, places: Array, velocity_m_s: Array) -> Array:
    """(..., n, k) s: from `starts` (n, 2) at `speeds_m_s` (n,) to `places` (..., k, 2) that all move with `velocity_m_s` (2,).

    Where a place cannot be caught up with: the time to where it is now, as if it stood.
    """
    way = places[..., None, :, :] - starts[:, None, :]
    speeds = speeds_m_s[:, None]
    a = float(velocity_m_s @ velocity_m_s) - speeds**2
    b = way @ velocity_m_s
    c = way[..., 0] ** 2 + way[..., 1] ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(b * b - a * c)
        early_s, late_s = (-b - root) / a, (-b + root) / a
        first_s = np.minimum(np.where(early_s >= 0.0, early_s, np.inf), np.where(late_s >= 0.0, late_s, np.inf))
    times_s: Array = np.where(first_s < np.inf, first_s, np.sqrt(c) / speeds)
    return times_s


def detours_m(starts: Array, ends: Array, discs: Array, margin_m: float) -> Array:
    """(...,) m: how much longer than straight the ways from `starts` (..., 2) to `ends` (..., 2) are around `discs` (m, >=3).

    Each disc for itself: the triangle over the point beside it. Discs that reach over an end cost nothing: they are there on
    every way.
    """
    if not len(discs):
        return np.zeros(np.broadcast_shapes(starts.shape, ends.shape)[:-1])
    way = ends - starts
    length = np.maximum(np.hypot(way[..., 0], way[..., 1]), 1e-9)
    unit = way / length[..., None]
    offset = discs[:, :2] - starts[..., None, :]
    along = offset[..., 0] * unit[..., None, 0] + offset[..., 1] * unit[..., None, 1]
    across = np.abs(offset[..., 0] * unit[..., None, 1] - offset[..., 1] * unit[..., None, 0])
    beside = np.maximum(discs[:, 2] + margin_m - across, 0.0)
    behind = length[..., None] - along
    reach = discs[:, 2] + margin_m
    bars = (along > reach) & (behind > reach) & (beside > 0.0)
    longer = np.hypot(along, beside) - along + np.hypot(behind, beside) - behind
    detours: Array = np.minimum(np.where(bars, longer, 0.0).sum(axis=-1), DETOUR_SHARE_MAX * length)
    return detours

"""Which tracks and sighted discs count: memory that ends, exclusions."""

from __future__ import annotations

import math

import numba

from perception.kernel_cache import njit
from perception.tracking.tracks import TRACKS_TYPE

_ESTABLISHED_S = 1.0
"""What stood still for so long outlives an exclusion that covers it."""

_F8, _B1 = numba.types.float64, numba.types.boolean


@njit(numba.void(TRACKS_TYPE, _F8, _F8, _F8, _B1[::1]), cache=True, nogil=True, error_model="numpy")
def outlive(tracks, t_s, memory_s, memory_moving_s, keep):  # type: ignore[no-untyped-def]
    """Whether each track was seen lately enough; a moving one, as a whole."""
    for j in range(tracks.shape[0]):
        track = tracks[j]
        keep[j] = t_s - track.seen_s <= memory_s and (track.is_moving == 0 or t_s - track.updated_s <= memory_moving_s)


@njit(numba.boolean(_F8, _F8, _F8[:, ::1]), cache=True, nogil=True, error_model="numpy")
def _is_inside(north, east, exclude):  # type: ignore[no-untyped-def]
    """Whether a place lies in one of the circles (k, 3)."""
    for k in range(exclude.shape[0]):
        to_north, to_east = north - exclude[k, 0], east - exclude[k, 1]
        if to_north * to_north + to_east * to_east <= exclude[k, 2] * exclude[k, 2]:
            return True
    return False


@njit(numba.int64(_F8[:, ::1], _F8[:, ::1], _B1[::1]), cache=True, nogil=True, error_model="numpy")
def usable(discs, exclude, wanted):  # type: ignore[no-untyped-def]
    """Mark the sighted discs (m, 3) that are finite and outside the circles; returns how many."""
    number = 0
    for i in range(discs.shape[0]):
        wanted[i] = math.isfinite(discs[i, 0]) and math.isfinite(discs[i, 1]) and math.isfinite(discs[i, 2])
        wanted[i] = wanted[i] and not _is_inside(discs[i, 0], discs[i, 1], exclude)
        number += wanted[i]
    return number


@njit(numba.void(TRACKS_TYPE, _F8, _F8[:, ::1], _B1[::1]), cache=True, nogil=True, error_model="numpy")
def withhold(tracks, t_s, exclude, keep):  # type: ignore[no-untyped-def]
    """Mark tracks inside the circles `exclude` (k, 3); only those that stood there for some time are worth keeping."""
    for j in range(tracks.shape[0]):
        track = tracks[j]
        track.is_withheld, keep[j] = 0, True
        # Where it is reported: what has not proven to move stays in its place, what was corrected now is no longer predicted.
        is_predicted = track.is_moving == 1 and track.updated_s < t_s
        north = track.now_north_m if is_predicted else track.north_m
        east = track.now_east_m if is_predicted else track.east_m
        if _is_inside(north, east, exclude):
            track.is_withheld = 1
            keep[j] = track.is_moving == 0 and track.seen_s - track.first_s >= _ESTABLISHED_S


@njit(numba.int64(TRACKS_TYPE, _B1[::1]), cache=True, nogil=True, error_model="numpy")
def compact(tracks, keep):  # type: ignore[no-untyped-def]
    """Move the tracks to keep to the front; returns how many they are."""
    kept = 0
    for j in range(tracks.shape[0]):
        if keep[j]:
            if kept < j:
                tracks[kept] = tracks[j]
            kept += 1
    return kept

"""Space that was seen to be free a moment ago: it does not stop being free because the picture now shows only sky beyond it.

A vehicle that brakes lifts its nose by up to 30 degrees. The ground, by which a bearing proves that the camera sees, then leaves
the picture, and between two trees nothing returns any more. Were such a bearing unseen at once, it would have to be flown slowly:
the vehicle would brake harder, keep its nose up and stay blind for it.

So a bearing in which nothing returned, and nothing had to, counts as seen if all of its line of sight, up to two thirds of the
range, lies in what frames of the last `free_memory_s` proved to be free: in a bearing that they saw by their own returns, before
the first surface found there. Whatever else hides a bearing - a glare or a cover over the ground, something near that is no
surface, a disc too small for its surface - is not outweighed by memory. What was hidden behind something then is not free now.
What can be wrong is what came into free space meanwhile and returns nothing; a camera that stalls for that long misses as much.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from perception.extraction.bearing_bins import BEARING_MAX_RAD, SECTORS, TANGENT_BINS, TANGENT_MAX, TANGENT_STEP
from perception.geometry import CameraPose
from perception.kernel_cache import njit
from perception.sighting import View

_VIEWS = 8
_REACH_FRACTION = 2 / 3
"""What lay beyond the range a moment ago is not known: at 6 m/s the last third of the range passes in half a second."""
_FIRST_M, _STEP_M = 0.5, 0.25
_BEFORE_SURFACE_M = 0.25


class FreeSpaceMemory:
    """The views of the last moments of one camera; bounded in memory. Not safe for use from two threads at once."""

    def __init__(self, memory_s: float) -> None:
        """memory_s: how long free space is remembered; 0: not at all."""
        self._memory_s = memory_s
        self._times_s = np.full(_VIEWS, -np.inf)
        self._cameras = np.zeros((_VIEWS, 5))
        self._seen = np.zeros((_VIEWS, SECTORS), np.bool_)
        self._nearest_m = np.zeros((_VIEWS, TANGENT_BINS))
        self._free = np.zeros(SECTORS, np.bool_)
        self._reach_m = 0.0
        self._next = 0

    def clear(self) -> None:
        """Forget everything."""
        self._times_s[:] = -np.inf

    def add(self, t_s: float, view: View) -> None:
        """Remember what the frame of `t_s` saw. Of frames in quick succession some are left out."""
        newest_s = self._times_s[self._next - 1]
        if self._memory_s <= 0.0 or 0.0 <= t_s - newest_s < self._memory_s / _VIEWS:
            return
        at = self._next
        self._times_s[at] = t_s
        self._cameras[at] = _camera_row(view)
        self._seen[at] = view.seen
        self._nearest_m[at] = view.nearest_m
        self._reach_m = _REACH_FRACTION * view.reliable_range_m
        self._next = (at + 1) % _VIEWS

    def free(self, t_s: float, camera: CameraPose, silent: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Those of the `silent` half-degree sectors ahead (360,) that lie in free space at `t_s`; good until the next call."""
        age_s = t_s - self._times_s
        recent = np.flatnonzero((age_s > 0.0) & (age_s <= self._memory_s))
        if not len(recent):
            self._free[:] = False
            return self._free
        _find_free(
            silent,
            float(camera.position_ned_m[0]),
            float(camera.position_ned_m[1]),
            camera.heading_rad,
            self._reach_m,
            recent[np.argsort(age_s[recent], kind="stable")],
            self._cameras,
            self._seen,
            self._nearest_m,
            self._free,
        )
        return self._free


def is_seen_free(view: View, north_m: float, east_m: float) -> bool:
    """Whether one frame showed a place, mission frame, to be free: in a bearing that it saw, before the first surface there."""
    return bool(_was_free(north_m, east_m, np.array(_camera_row(view)), view.seen, view.nearest_m))


def _camera_row(view: View) -> tuple[float, float, float, float, float]:
    """North, east, heading, depth per metre forward, reliable range: what `_was_free` is told of a view."""
    camera = view.camera
    north_m, east_m = camera.position_ned_m[:2]
    return float(north_m), float(east_m), camera.heading_rad, float(camera.level[0, 2]), view.reliable_range_m


@njit("b1(f8,f8,f8[::1],b1[::1],f8[::1])", cache=True, nogil=True, error_model="numpy")
def _was_free(north, east, camera, seen, nearest):  # type: ignore[no-untyped-def]
    """Whether one view showed a place to be free. camera: north, east, heading, depth per metre forward, reliable range."""
    cos, sin = math.cos(camera[2]), math.sin(camera[2])
    to_north, to_east = north - camera[0], east - camera[1]
    ahead, aside = to_north * cos + to_east * sin, to_east * cos - to_north * sin
    if ahead <= 0.0 or ahead * camera[3] > camera[4] or abs(aside) >= (TANGENT_MAX - TANGENT_STEP) * ahead:
        return False
    sector = int((math.atan2(aside, ahead) + math.pi / 2) / math.pi * seen.shape[0])
    for k in range(max(sector - 1, 0), min(sector + 2, seen.shape[0])):
        if not seen[k]:
            return False
    b = int((aside / ahead + TANGENT_MAX) / TANGENT_STEP)
    return min(nearest[b - 1], nearest[b], nearest[b + 1]) >= ahead + _BEFORE_SURFACE_M


@njit("void(b1[::1],f8,f8,f8,f8,i8[::1],f8[:,::1],b1[:,::1],f8[:,::1],b1[::1])", cache=True, nogil=True, error_model="numpy")
def _find_free(  # type: ignore[no-untyped-def]
    silent, north, east, heading, reach, recent, cameras, seen, nearest, free
):
    """Fill free (360,). recent: views to ask, newest first."""
    for sector in range(silent.shape[0]):
        bearing = (sector + 0.5) / silent.shape[0] * math.pi - math.pi / 2
        free[sector] = silent[sector] and abs(bearing) < BEARING_MAX_RAD
        if not free[sector]:
            continue
        cos, sin = math.cos(heading + bearing), math.sin(heading + bearing)
        for step in range(int((reach - _FIRST_M) / _STEP_M) + 1):
            distance = _FIRST_M + step * _STEP_M
            known = False
            for k in recent:
                if _was_free(north + distance * cos, east + distance * sin, cameras[k], seen[k], nearest[k]):
                    known = True
                    break
            if not known:
                free[sector] = False
                break

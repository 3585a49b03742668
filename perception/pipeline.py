"""One depth frame and the pose it was taken from -> discs and unseen sectors in the mission frame."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from perception.extraction.extractor import Extraction, Extractor
from perception.free_space import FreeSpaceMemory
from perception.geometry import MountingLike
from perception.parameters import PerceptionParameters
from perception.sectors import WHOLE_CIRCLE, unseen_sectors
from perception.sighting import View
from perception.tracking.tracker import DiscTracker, TrackedDiscs
from perception.types import DepthFrame, PerceivedObstacles, VehiclePose

NO_EXCLUSION = np.zeros((0, 3))


class PerceptionPipeline:
    """Extraction and tracking for one camera. Not safe for use from two threads at once; never raises on a bad frame.

    mounting: pose of the camera in the body frame. range_min_m, range_max_m: depths outside are not believed.
    ground_down_m: height of the ground in the mission frame (0 = at the datum); None if it is not known, then only the height
    band keeps the ground out, and it cannot tell whether the picture fits the mounting and the lens.

    What counts as unseen: bearings outside the picture; everything, if the frame or the pose is bad (extraction/faults.py) or
    the frame contradicts the ground; and what no return proves to be in sight (extraction/blindness.py), unless it was seen to
    be free a moment ago (free_space.py).
    """

    def __init__(
        self,
        parameters: PerceptionParameters,
        mounting: MountingLike,
        *,
        range_min_m: float = 0.3,
        range_max_m: float = 10.0,
        ground_down_m: float | None = 0.0,
    ) -> None:
        self._parameters = parameters
        self._extractor = Extractor(parameters, mounting, range_min_m, range_max_m, ground_down_m)
        self._tracker = DiscTracker(parameters)
        self._free_space = FreeSpaceMemory(parameters.free_memory_s)

    def reset(self) -> None:
        """Forget everything seen so far."""
        self._extractor.reset()
        self._tracker.clear()
        self._free_space.clear()

    def process(self, frame: DepthFrame, pose: VehiclePose, exclude: NDArray[np.float64] = NO_EXCLUSION) -> PerceivedObstacles:
        """Obstacles at the frame's capture time.

        pose: of the vehicle at that time. exclude: (k, 3) north_m, east_m, radius_m of teammates and the target, which are not
        obstacles; a row that is no circle leaves nothing out. Returns at most `discs_max` discs, nearest first, with unknown
        heights (-inf, +inf).
        """
        exclude, is_usable = _usable(exclude)
        extraction = self._extractor.extract(frame, pose, exclude)
        tracked = self._tracker.update(frame.t_s, extraction.sighting, exclude)
        places = np.full((len(is_usable), 2), np.nan)
        if len(exclude):
            places[is_usable] = _without_standing(extraction.left_out, exclude, tracked.standing)
        unseen = self._unseen(frame.t_s, extraction)
        events = (extraction.event,) if extraction.event else ()
        view = None if extraction.sighting is None else extraction.sighting.view
        return self._obstacles(frame.t_s, tracked, pose, unseen, events, places, view)

    def _unseen(self, t_s: float, extraction: Extraction) -> NDArray[np.float64]:
        """(k, 2) bearings that neither this frame saw nor those just before it, where this one shows nothing but perhaps sky."""
        sighting = extraction.sighting
        if sighting is None or extraction.silent is None:
            return WHOLE_CIRCLE.copy()
        free = self._free_space.free(t_s, sighting.view.camera, extraction.silent)
        self._free_space.add(t_s, sighting.view)
        return unseen_sectors(sighting.view.seen | free, sighting.view.camera.heading_rad)

    def _obstacles(
        self,
        t_s: float,
        tracked: TrackedDiscs,
        pose: VehiclePose,
        unseen: NDArray[np.float64],
        events: tuple[str, ...],
        left_out: NDArray[np.float64],
        view: View | None,
    ) -> PerceivedObstacles:
        """At most `discs_max` discs, nearest surface first, in ObstacleSet's columns."""
        discs = tracked.discs
        north_m, east_m = pose.position_ned_m[:2]
        gap = np.hypot(discs[:, 0] - north_m, discs[:, 1] - east_m) - discs[:, 2]
        nearest = np.argsort(gap, kind="stable")[: self._parameters.discs_max]
        out = np.empty((len(nearest), 7))
        out[:, :5] = discs[nearest]
        out[:, 5], out[:, 6] = -math.inf, math.inf
        return PerceivedObstacles(t_s, out, tracked.age_s[nearest], tracked.confidence[nearest], unseen, events, left_out, view)


def _usable(exclude: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """The rows that are circles, and which they are. Of anything else, nothing is left out of the obstacles."""
    rows = np.ascontiguousarray(exclude, np.float64)
    if rows.ndim != 2 or rows.shape[1] != 3:
        return NO_EXCLUSION, np.zeros(0, np.bool_)
    is_usable = np.isfinite(rows).all(axis=1) & (rows[:, 2] > 0)
    return np.ascontiguousarray(rows[is_usable]), is_usable


def _without_standing(
    left_out: NDArray[np.float64], exclude: NDArray[np.float64], standing: NDArray[np.float64]
) -> NDArray[np.float64]:
    """`left_out` (k, 2), nan for circles in which something stood before: nobody can tell which of the two was seen."""
    if len(standing):
        away = np.hypot(exclude[:, None, 0] - standing[None, :, 0], exclude[:, None, 1] - standing[None, :, 1])
        left_out[(away <= exclude[:, 2, None]).any(axis=1)] = np.nan
    return left_out

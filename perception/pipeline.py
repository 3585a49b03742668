"""One depth frame and the pose it was taken from -> discs and unseen sectors in the mission frame."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from perception.extraction.extractor import Extractor
from perception.geometry import MountingLike
from perception.parameters import PerceptionParameters
from perception.sectors import WHOLE_CIRCLE, unseen_sectors
from perception.tracking.tracker import DiscTracker, TrackedDiscs
from perception.types import DepthFrame, PerceivedObstacles, VehiclePose

NO_EXCLUSION = np.zeros((0, 3))


class PerceptionPipeline:
    """Extraction and tracking for one camera. Not safe for use from two threads at once; never raises on a bad frame.

    mounting: pose of the camera in the body frame. range_min_m, range_max_m: depths outside are not believed.
    ground_down_m: height of the ground in the mission frame (0 = at the datum); None if it is not known, then only the height
    band keeps the ground out, and it cannot tell whether the picture fits the mounting and the lens.

    What counts as unseen: bearings outside the picture; everything, if the frame or the pose is bad (extraction/faults.py) or
    the frame contradicts the ground; and what no return proves to be in sight (extraction/blindness.py).
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

    def reset(self) -> None:
        """Forget everything seen so far."""
        self._extractor.reset()
        self._tracker.clear()

    def process(self, frame: DepthFrame, pose: VehiclePose, exclude: NDArray[np.float64] = NO_EXCLUSION) -> PerceivedObstacles:
        """Obstacles at the frame's capture time.

        pose: of the vehicle at that time. exclude: (k, 3) north_m, east_m, radius_m of teammates and the target, which are not
        obstacles. Returns at most `discs_max` discs, nearest first, with unknown heights (-inf, +inf).
        """
        exclude = _usable(exclude)
        extraction = self._extractor.extract(frame, pose, exclude)
        tracked = self._tracker.update(frame.t_s, extraction.sighting, exclude)
        unseen = WHOLE_CIRCLE.copy()
        if extraction.sighting is not None:
            view = extraction.sighting.view
            unseen = unseen_sectors(view.seen, view.camera.heading_rad)
        return self._obstacles(frame.t_s, tracked, pose, unseen, (extraction.event,) if extraction.event else ())

    def _obstacles(
        self, t_s: float, tracked: TrackedDiscs, pose: VehiclePose, unseen: NDArray[np.float64], events: tuple[str, ...]
    ) -> PerceivedObstacles:
        """At most `discs_max` discs, nearest surface first, in ObstacleSet's columns."""
        discs = tracked.discs
        north_m, east_m = pose.position_ned_m[:2]
        gap = np.hypot(discs[:, 0] - north_m, discs[:, 1] - east_m) - discs[:, 2]
        nearest = np.argsort(gap, kind="stable")[: self._parameters.discs_max]
        out = np.empty((len(nearest), 7))
        out[:, :5] = discs[nearest]
        out[:, 5], out[:, 6] = -math.inf, math.inf
        return PerceivedObstacles(t_s, out, tracked.age_s[nearest], tracked.confidence[nearest], unseen, events)


def _usable(exclude: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rows that are circles. Of anything else, nothing is left out of the obstacles."""
    rows = np.ascontiguousarray(exclude, np.float64)
    if rows.ndim != 2 or rows.shape[1] != 3 or not len(rows):
        return NO_EXCLUSION
    return np.ascontiguousarray(rows[np.isfinite(rows).all(axis=1) & (rows[:, 2] > 0)])

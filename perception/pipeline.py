"""One depth frame and the pose it was taken from -> discs and unseen sectors in the mission frame."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from perception.cells import CellGrid
from perception.covering import cover
from perception.geometry import CameraPose, MountingLike, camera_pose, is_finite
from perception.parameters import PerceptionParameters
from perception.sectors import WHOLE_CIRCLE, GroundCheck, in_view, unseen_sectors
from perception.sighting import Sighting, View
from perception.tracking.tracker import DiscTracker, TrackedDiscs
from perception.types import DepthFrame, PerceivedObstacles, VehiclePose

NO_EXCLUSION = np.zeros((0, 3))

_DEPTH_MAX = 65535
_CHECK_STEP_PX = 16
_BLIND_FRACTION = 0.25
"""A stereo camera never returns anything along its left edge: only a larger blind part is worth an event."""


class PerceptionPipeline:
    """Extraction and tracking for one camera. Not safe for use from two threads at once; never raises on a bad frame.

    mounting: pose of the camera in the body frame. range_min_m, range_max_m: depths outside are not believed.
    ground_down_m: height of the ground in the mission frame (0 = at the datum); None if it is not known, then only the height
    band keeps the ground out and a covered lens cannot be told from open sky.

    What counts as unseen: bearings outside the picture; everything, if the frame is invalid (wrong size, no return at all, all at
    the maximum, frozen) or the pose is not finite; and sectors in which the ground was due within range but too little returned.
    Elsewhere no return means free: a depth camera returns nothing from open space. A frame without any return is invalid
    unless no ground was due in it and the last good frame is not older than `sky_hold_s`.
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
        cv2.setNumThreads(1)
        self._parameters = parameters
        self._mounting = mounting
        self._range_min_m = range_min_m
        self._ground_down_m = ground_down_m
        self._grid = CellGrid(parameters, range_min_m, range_max_m)
        self._ground = GroundCheck(parameters, range_max_m)
        self._tracker = DiscTracker(parameters)
        self._last_good_s = -math.inf
        self._last_sample: NDArray[np.uint16] | None = None
        self._same = 0

    def reset(self) -> None:
        """Forget everything seen so far."""
        self._tracker.clear()
        self._last_good_s = -math.inf
        self._last_sample = None
        self._same = 0

    def process(self, frame: DepthFrame, pose: VehiclePose, exclude: NDArray[np.float64] = NO_EXCLUSION) -> PerceivedObstacles:
        """Obstacles at the frame's capture time.

        pose: of the vehicle at that time. exclude: (k, 3) north_m, east_m, radius_m of teammates and the target, which are not
        obstacles. Returns at most `discs_max` discs, nearest first, with unknown heights (-inf, +inf).
        """
        exclude = exclude[np.isfinite(exclude).all(axis=1) & (exclude[:, 2] > 0)] if len(exclude) else NO_EXCLUSION
        fault = self._fault(frame, pose)
        if fault:
            return self._blind(frame.t_s, pose, exclude, fault)
        camera = camera_pose(pose, self._mounting)
        blind, ground_due = self._ground.blind(frame.depth, frame.intrinsics, camera, self._ground_down_m)
        if not frame.depth.any():
            if ground_due:
                return self._blind(frame.t_s, pose, exclude, "depth frame is empty although the ground is in range")
            if not 0 <= frame.t_s - self._last_good_s <= self._parameters.sky_hold_s:
                return self._blind(frame.t_s, pose, exclude, "depth frame is empty: no pixel returned a distance")
        else:
            self._last_good_s = frame.t_s
        in_picture = in_view(camera, frame.intrinsics, pose.position_ned_m[2], self._parameters)
        seen = in_picture & ~blind
        events: tuple[str, ...] = ()
        if np.count_nonzero(seen) < (1 - _BLIND_FRACTION) * np.count_nonzero(in_picture):
            events = ("part of the depth frame is blind: no return where the ground is in range",)
        points = self._grid.points(
            frame.depth,
            frame.depth_unit_m,
            frame.intrinsics,
            camera,
            pose.position_ned_m[2],
            self._ground_down_m,
            exclude,
        )
        observed = _to_mission(cover(points, self._parameters), camera)
        followed_m = np.where(np.isfinite(points.nearest_m), points.nearest_m, 0.0)
        view = View(camera, seen, points.nearest_m, followed_m, self._range_min_m, self._grid.reliable_range_m)
        sighting = Sighting(observed, np.zeros(len(observed)), np.ones(len(observed)), np.zeros(len(observed), np.bool_), view)
        tracked = self._tracker.update(frame.t_s, sighting, exclude)
        return self._obstacles(frame.t_s, tracked, pose, unseen_sectors(seen, camera.heading_rad), events)

    def _fault(self, frame: DepthFrame, pose: VehiclePose) -> str:
        """What makes the frame unusable, or nothing."""
        wanted = (frame.intrinsics.height_px, frame.intrinsics.width_px)
        depth = frame.depth
        if depth.shape != wanted:
            size = "x".join(str(length) for length in depth.shape[::-1])
            return f"depth frame has the wrong size: {size or 'none'} instead of {wanted[1]}x{wanted[0]}"
        if depth.dtype != np.uint16 or not depth.size:
            return f"depth frame has no 16-bit pixels: {depth.dtype}, {depth.size} pixels"
        if not is_finite(pose):
            return "vehicle pose at the depth frame's time is not finite"
        sample = depth[::_CHECK_STEP_PX, ::_CHECK_STEP_PX]
        if sample.min() == _DEPTH_MAX and depth.min() == _DEPTH_MAX:
            return f"every pixel of the depth frame is at the maximum, {_DEPTH_MAX}"
        same = self._last_sample is not None and np.array_equal(sample, self._last_sample) and bool(sample.any())
        self._same = self._same + 1 if same else 0
        self._last_sample = sample.copy()
        if self._parameters.frozen_frames_max and self._same >= self._parameters.frozen_frames_max:
            return f"depth image is frozen: the same pixels for {self._same + 1} frames"
        return ""

    def _blind(self, t_s: float, pose: VehiclePose, exclude: NDArray[np.float64], event: str) -> PerceivedObstacles:
        """Nothing was seen: what is remembered, and the whole circle unseen."""
        tracked = self._tracker.update(t_s, None, exclude)
        return self._obstacles(t_s, tracked, pose, WHOLE_CIRCLE.copy(), (event,))

    def _obstacles(
        self, t_s: float, tracked: TrackedDiscs, pose: VehiclePose, unseen: NDArray[np.float64], events: tuple[str, ...]
    ) -> PerceivedObstacles:
        """At most `discs_max` discs, nearest surface first, in ObstacleSet's columns."""
        discs = tracked.discs
        gap = np.hypot(discs[:, 0] - pose.position_ned_m[0], discs[:, 1] - pose.position_ned_m[1]) - discs[:, 2]
        nearest = np.argsort(gap, kind="stable")[: self._parameters.discs_max]
        out = np.empty((len(nearest), 7))
        out[:, :5] = discs[nearest]
        out[:, 5], out[:, 6] = -np.inf, np.inf
        return PerceivedObstacles(t_s, out, tracked.age_s[nearest], tracked.confidence[nearest], unseen, events)


def _to_mission(discs: NDArray[np.float64], camera: CameraPose) -> NDArray[np.float64]:
    """Discs (n, 3) forward, right, radius in the level frame -> north, east, radius in the mission frame."""
    cos, sin = math.cos(camera.heading_rad), math.sin(camera.heading_rad)
    out = discs.copy()
    out[:, 0] = camera.position_ned_m[0] + discs[:, 0] * cos - discs[:, 1] * sin
    out[:, 1] = camera.position_ned_m[1] + discs[:, 0] * sin + discs[:, 1] * cos
    return out

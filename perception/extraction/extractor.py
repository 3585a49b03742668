"""One depth frame -> the discs in it and the sectors it shows, in the mission frame."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from perception.extraction.bearing_bins import TANGENT_BINS
from perception.extraction.blindness import EvidenceSurvey
from perception.extraction.covering import Coverer
from perception.extraction.faults import FaultFinder
from perception.extraction.height_band import height_band
from perception.extraction.left_out import left_out
from perception.extraction.pixels import PixelCounter
from perception.extraction.polar_grid import DistanceCells
from perception.extraction.surfaces import SurfaceFinder
from perception.extraction.uncovered import UncoveredSurfaces
from perception.extraction.unexplained import UnexplainedReturns
from perception.geometry import CameraPose, MountingLike, camera_pose
from perception.parameters import PerceptionParameters
from perception.sectors import in_view
from perception.sighting import Sighting, View
from perception.types import DepthFrame, VehiclePose

_BLIND_FRACTION = 0.25
"""A stereo camera never returns anything along its left edge: only a larger blind part is worth an event."""


@dataclass(frozen=True, slots=True)
class Extraction:
    """sighting: what the frame showed, None if it showed nothing. event: what was wrong with it, one sentence, or nothing.

    left_out: (k, 2) what stood in each exclusion, see `extraction.left_out`.
    silent: (360,) half-degree sectors ahead that are not seen for one reason alone: nothing returned, as from the sky, and
    nothing had to. None if nothing was shown at all.
    """

    sighting: Sighting | None
    event: str
    left_out: NDArray[np.float64]
    silent: NDArray[np.bool_] | None = None


class Extractor:
    """Extraction for one camera; what is held is made once for an image size. `extract` never raises on a bad frame."""

    def __init__(
        self,
        parameters: PerceptionParameters,
        mounting: MountingLike,
        range_min_m: float,
        range_max_m: float,
        ground_down_m: float | None,
    ) -> None:
        self._parameters = parameters
        self._mounting = mounting
        self._range_min_m = range_min_m
        self._ground_down_m = ground_down_m
        self._faults = FaultFinder(parameters)
        cells = DistanceCells(parameters, range_max_m)
        self._pixels = PixelCounter(parameters, cells, range_min_m, range_max_m)
        self._surfaces = SurfaceFinder(parameters, cells, range_max_m)
        self._coverer = Coverer(parameters, range_max_m, TANGENT_BINS * len(cells))
        self._unexplained = UnexplainedReturns(parameters.depth_noise_1_m, self._surfaces.reliable_range_m)
        self._uncovered = UncoveredSurfaces(parameters.depth_noise_1_m)
        self._survey = EvidenceSurvey(parameters, range_min_m, range_max_m, self._surfaces.reliable_range_m)

    def reset(self) -> None:
        """Forget the last frame."""
        self._faults.reset()

    def extract(self, frame: DepthFrame, pose: VehiclePose, exclude: NDArray[np.float64]) -> Extraction:
        """What one frame shows. exclude: (k, 3) north_m, east_m, radius_m of what is no obstacle, all finite."""
        fault = self._faults.fault(frame, pose)
        if fault:
            return Extraction(None, fault, np.full((len(exclude), 2), np.nan))
        depth = np.ascontiguousarray(frame.depth)
        if depth is not frame.depth:
            frame = DepthFrame(frame.t_s, frame.number, depth, frame.depth_unit_m, frame.intrinsics)
        camera = camera_pose(pose, self._mounting)
        band = height_band(pose, camera, self._ground_down_m, self._parameters)
        evidence = self._survey.survey(frame, camera, band, self._ground_down_m)
        if evidence.fault:
            return Extraction(None, evidence.fault, np.full((len(exclude), 2), np.nan))
        in_picture = in_view(camera, frame.intrinsics, pose.position_ned_m[2], self._parameters)
        seen = in_picture & ~evidence.hidden
        event = ""
        if np.count_nonzero(in_picture & evidence.is_blind) > _BLIND_FRACTION * np.count_nonzero(in_picture):
            event = "part of the depth frame is blind: too few pixels returned a distance to tell what is there"
        self._pixels.count(frame, camera, band)
        points = self._surfaces.find(self._pixels.grid, self._pixels.is_cut, frame.intrinsics, camera, exclude)
        unexplained = self._unexplained.sectors(evidence, points.nearest_m, float(camera.level[0, 2]))
        seen &= ~unexplained
        found = self._coverer.cover(points, seen, camera, self._surfaces.reliable_range_m)
        uncovered = self._uncovered.sectors(points, found.discs)
        seen &= ~uncovered
        silent = in_picture & evidence.hidden & ~(evidence.is_blind | unexplained | uncovered)
        view = View(
            camera,
            seen,
            points.nearest_m.copy(),
            evidence.furthest_m.copy(),
            self._range_min_m,
            self._surfaces.reliable_range_m,
        )
        discs = _to_mission(found.discs, camera)
        places = left_out(points, camera, exclude, self._parameters.depth_noise_1_m)
        return Extraction(Sighting(discs, found.sigma_m, found.confidence, found.is_whole, view), event, places, silent)


def _to_mission(discs: NDArray[np.float64], camera: CameraPose) -> NDArray[np.float64]:
    """Discs (n, 3) forward, right, radius in the level frame -> north, east, radius in the mission frame."""
    cos, sin = math.cos(camera.heading_rad), math.sin(camera.heading_rad)
    out = np.empty((len(discs), 3))
    out[:, 0] = camera.position_ned_m[0] + discs[:, 0] * cos - discs[:, 1] * sin
    out[:, 1] = camera.position_ned_m[1] + discs[:, 0] * sin + discs[:, 1] * cos
    out[:, 2] = discs[:, 2]
    return out

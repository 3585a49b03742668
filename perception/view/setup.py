"""How perception is set up for a source: what the person says counts, then what the recording says, then what is usual."""

from __future__ import annotations

from dataclasses import dataclass

from perception.errors import PerceptionInputError
from perception.geometry import CameraMounting
from perception.parameters import PerceptionParameters
from perception.pipeline import PerceptionPipeline
from perception.sources.api import DepthSource
from perception.sources.mcap import McapSource, RecordedCamera
from perception.types import VehiclePose
from perception.view.arguments import ViewOptions

_RANGE_MIN_M, _RANGE_MAX_M = 0.3, 10.0
_BAND_WITHOUT_POSE_M = 0.3
"""What a hand-held camera or a small robot could hit, instead of the metre of a vehicle in flight."""
_HEIGHT_UNKNOWN_M = 1000.0
"""Who does not say how high the camera is gets no ground removed, and no complaint about a ground in the wrong place."""


@dataclass(frozen=True, slots=True)
class Setup:
    """Everything that the pipeline needs beside the frames; ground_down_m in the frame of the poses.

    level_pose: for frames without one.
    """

    parameters: PerceptionParameters
    mounting: CameraMounting
    range_min_m: float
    range_max_m: float
    ground_down_m: float
    level_pose: VehiclePose

    def new_pipeline(self) -> PerceptionPipeline:
        return PerceptionPipeline(
            self.parameters,
            self.mounting,
            range_min_m=self.range_min_m,
            range_max_m=self.range_max_m,
            ground_down_m=self.ground_down_m,
        )


def setup_for(options: ViewOptions, source: DepthSource) -> Setup:
    """PerceptionInputError if what the person says and what the recording says do not fit together."""
    recorded = _recorded(source)
    range_min_m = _first(options.range_min_m, None if recorded is None else recorded.range_min_m, _RANGE_MIN_M)
    range_max_m = _first(options.range_max_m, None if recorded is None else recorded.range_max_m, _RANGE_MAX_M)
    if not 0 <= range_min_m < range_max_m:
        raise PerceptionInputError(
            f"--range-min-m = {range_min_m}: at least 0 and less than the range's end, {range_max_m} m, is wanted"
        )
    parameters = options.parameters
    if options.band_m is not None:
        parameters = parameters.model_copy(update={"band_m": options.band_m})
    elif not options.has_profile and recorded is None and options.source != "synthetic":
        parameters = parameters.model_copy(update={"band_m": _BAND_WITHOUT_POSE_M})
    mounting = options.mounting or (recorded.mounting if recorded is not None else CameraMounting())
    height_m = _first(options.height_m, _HEIGHT_UNKNOWN_M)
    ground_down_m = _first(options.ground_down_m, None if recorded is None else recorded.ground_down_m, 0.0)
    level_pose = VehiclePose((0.0, 0.0, ground_down_m - height_m), (0.0, 0.0, 0.0), options.roll_rad, options.pitch_rad, 0.0)
    return Setup(parameters, mounting, range_min_m, range_max_m, ground_down_m, level_pose)


def _recorded(source: DepthSource) -> RecordedCamera | None:
    """What a flight's recording tells about its camera."""
    return source.camera if isinstance(source, McapSource) else None


def _first(*values: float | None) -> float:
    return next(value for value in values if value is not None)

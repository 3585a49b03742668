"""From a depth frame to discs; beside it, plain NumPy and the RealSense SDK on the same frames; and rendering a frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flightapp.bench.depth_flight import FRAMES, DepthFlight, Shot, depth_flight, pose_at, renderer_of, wood_between_walls
from flightapp.bench.measurement import Measurement, Work, measure
from flightapp.bench.realsense_sdk import sdk_measurement
from flightapp.config.mission import Mission, Vehicle
from flightapp.config.profile import Profile
from flightapp.sim.world import World
from perception.geometry import camera_pose
from perception.pipeline import PerceptionPipeline

PLAIN, RICH = "perception, frame to tracked discs", "perception, the same in a wood between walls"
NUMPY_ROW = "NumPy, the whole frame in float64"
PERCEPTION_AIM_MS = 2.0
CELL_M = 0.1


def camera_measurements(mission: Mission, profile: Profile, vehicle: Vehicle, seconds: float) -> list[Measurement]:
    """Perceiving a frame among the mission's obstacles and in a wood, the references on the wood's frames, rendering.

    `seconds` for all. Without the row of the SDK where that cannot be imported.
    """
    camera, start = profile.camera, vehicle.start
    world = World(mission.obstacles)
    wood = depth_flight(wood_between_walls(), camera, 0.0, 0.0)
    plain = _perceiving(PLAIN, profile, depth_flight(world, camera, start.north_m, start.east_m), -start.ground_height_m, seconds)
    rich = _perceiving(RICH, profile, wood, 0.0, seconds)
    numpy = measure(
        Work(NUMPY_ROW, wood.shot, lambda shot: _naive(shot, camera_pose(shot[1], camera.mounting).rotation)), 0.15 * seconds
    )
    sdk = sdk_measurement(wood, 0.15 * seconds)
    rich = replace(
        rich,
        faster_by=numpy.cpu_ms.p50 / rich.cpu_ms.p50,
        sdk_ratio=None if sdk is None else sdk.cpu_ms.p50 / rich.cpu_ms.p50,
    )
    renderer = renderer_of(world, camera)
    rendering = measure(
        Work(
            "simulation, depth render",
            lambda k: camera_pose(pose_at(k % FRAMES, start.north_m, start.east_m), camera.mounting),
            lambda pose: renderer.render(pose, 0),
        ),
        0.1 * seconds,
    )
    return [plain, rich, numpy, *([] if sdk is None else [sdk]), rendering]


def pipeline_of(profile: Profile, ground_down_m: float) -> PerceptionPipeline:
    """As in flight."""
    camera = profile.camera
    return PerceptionPipeline(
        profile.perception,
        camera.mounting,
        range_min_m=camera.range_min_m,
        range_max_m=camera.range_max_m,
        ground_down_m=ground_down_m,
    )


def _perceiving(name: str, profile: Profile, flight: DepthFlight, ground_down_m: float, seconds: float) -> Measurement:
    pipeline = pipeline_of(profile, ground_down_m)

    def perceive(shot: Shot) -> None:
        if events := pipeline.process(*shot).events:
            raise RuntimeError(f"the frame was refused, this would measure something else: {events[0]}")

    return measure(Work(name, flight.shot, perceive, PERCEPTION_AIM_MS, warm_up=FRAMES), 0.3 * seconds)


def _naive(shot: Shot, rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    """Occupied cells (k, 2) of the height band: every pixel back-projected and rotated in float64."""
    frame, pose = shot
    k = frame.intrinsics
    rows, columns = np.mgrid[0 : k.height_px, 0 : k.width_px]
    z = frame.depth * frame.depth_unit_m
    optical = np.stack(((columns - k.cx_px) / k.fx_px * z, (rows - k.cy_px) / k.fy_px * z, z), axis=2)
    points = optical.reshape(-1, 3)[z.ravel() > 0.0] @ rotation.T + pose.position_ned_m
    band = points[np.abs(points[:, 2] - pose.position_ned_m[2]) < 1.0, :2]
    return np.unique(np.floor(band / CELL_M), axis=0)

"""From the simulated world to a depth frame, and from a depth frame to discs, on a flight through the mission's obstacles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flightapp.bench.measurement import Measurement, Work, measure
from flightapp.bench.situation import HEIGHT_M, straight
from flightapp.config.mission import Mission, Vehicle
from flightapp.config.profile import Profile
from flightapp.sim.camera import intrinsics_of
from flightapp.sim.world import World
from perception.geometry import camera_pose
from perception.pipeline import PerceptionPipeline
from perception.synthetic.depth_renderer import DEPTH_UNIT_M, DepthRenderer
from perception.types import DepthFrame, VehiclePose

PERCEPTION_AIM_MS = 3.0
FRAMES = 60
CELL_M = 0.1

Shot = tuple[DepthFrame, VehiclePose]


def camera_measurements(mission: Mission, profile: Profile, vehicle: Vehicle, seconds: float) -> list[Measurement]:
    """Rendering a frame, and perceiving it; `seconds` for both."""
    camera, intrinsics = profile.camera, intrinsics_of(profile.camera)
    renderer = DepthRenderer(World(mission.obstacles), intrinsics, range_min_m=camera.range_min_m)
    pipeline = PerceptionPipeline(
        profile.perception,
        camera.mounting,
        ground_down_m=-vehicle.start.ground_height_m,
        range_min_m=camera.range_min_m,
        range_max_m=camera.range_max_m,
    )

    def shoot(k: int) -> Shot:
        pose = _pose(k, vehicle)
        depth = renderer.render(camera_pose(pose, camera.mounting), k)
        return DepthFrame(straight(k).t_s, k, depth, DEPTH_UNIT_M, intrinsics), pose

    def perceive(shot: Shot) -> None:
        if events := pipeline.process(*shot).events:
            raise RuntimeError(f"the frame was refused, this would measure something else: {events[0]}")

    rendering = measure(
        Work(
            "simulation, depth render",
            lambda k: camera_pose(_pose(k, vehicle), camera.mounting),
            lambda pose: renderer.render(pose, 0),
        ),
        0.2 * seconds,
    )
    perception = measure(Work("perception, frame to discs", shoot, perceive, PERCEPTION_AIM_MS), 0.6 * seconds)
    naive = measure(
        Work("whole frame in float64", shoot, lambda shot: _naive(shot, camera_pose(shot[1], camera.mounting).rotation)),
        0.2 * seconds,
    )
    return [replace(perception, faster_by=naive.cpu_ms.p50 / perception.cpu_ms.p50), rendering]


def _pose(k: int, vehicle: Vehicle) -> VehiclePose:
    """Where the vehicle is in frame `k`: again and again along the first 6 m of its way north, pitching."""
    state = straight(k % FRAMES)
    north = vehicle.start.north_m + float(state.position_ned_m[0])
    pitch = -0.1 + 0.05 * ((k % 20) / 20.0)
    return VehiclePose((north, vehicle.start.east_m, -HEIGHT_M), (3.0, 0.0, 0.0), 0.05, pitch, 0.0)


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

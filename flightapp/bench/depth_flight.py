"""Depth frames of a flight to and fro, rendered beforehand: perception is measured, not the renderer."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from flightapp.bench.situation import HEIGHT_M, PERIOD_S
from flightapp.config.profile import Camera
from flightapp.sim.camera import intrinsics_of
from perception.geometry import camera_pose
from perception.synthetic.depth_renderer import DEPTH_UNIT_M, DepthRenderer
from perception.synthetic.scene import Scene, SceneLike
from perception.types import DepthFrame, VehiclePose

FRAMES = 60
"""Of one way; then the vehicle flies the same way back, looking north all the time."""
SPEED_M_S = 3.0

Shot = tuple[DepthFrame, VehiclePose]


@dataclass(frozen=True, slots=True)
class DepthFlight:
    """The frames of one way, in order."""

    shots: tuple[Shot, ...]

    def shot(self, k: int) -> Shot:
        """Frame `k` of the flight to and fro, at its own time."""
        ways, place = divmod(k, FRAMES)
        is_back = ways % 2 == 1
        frame, pose = self.shots[FRAMES - 1 - place if is_back else place]
        velocity = (-SPEED_M_S if is_back else SPEED_M_S, 0.0, 0.0)
        return replace(frame, t_s=k * PERIOD_S, number=k), replace(pose, velocity_ned_m_s=velocity)


def depth_flight(scene: SceneLike, camera: Camera, north_m: float, east_m: float) -> DepthFlight:
    """6 m north from there in two seconds, 5 m above the datum, pitching as a multirotor does."""
    renderer = renderer_of(scene, camera)
    shots = []
    for k in range(FRAMES):
        pose = pose_at(k, north_m, east_m)
        depth = renderer.render(camera_pose(pose, camera.mounting), k)
        shots.append((DepthFrame(k * PERIOD_S, k, depth, DEPTH_UNIT_M, intrinsics_of(camera)), pose))
    return DepthFlight(tuple(shots))


def renderer_of(scene: SceneLike, camera: Camera) -> DepthRenderer:
    return DepthRenderer(scene, intrinsics_of(camera), range_min_m=camera.range_min_m)


def pose_at(k: int, north_m: float, east_m: float) -> VehiclePose:
    """Where the vehicle is in frame `k` of one way."""
    pitch_rad = -0.1 + 0.05 * math.sin(k * math.tau / 20.0)
    return VehiclePose((north_m + SPEED_M_S * PERIOD_S * k, east_m, -HEIGHT_M), (SPEED_M_S, 0.0, 0.0), 0.05, pitch_rad, 0.0)


def wood_between_walls() -> Scene:
    """As much as a frame can show: a way between two walls, 90 trunks with branches between them, a front at the end."""
    random = np.random.default_rng(4)
    trunks, branches = 90, 40
    cylinders = np.column_stack(
        (
            random.uniform(1.5, 18.0, trunks),
            random.uniform(0.8, 3.0, trunks) * random.choice((-1.0, 1.0), trunks),
            random.uniform(0.03, 0.25, trunks),
            np.full(trunks, 9.0),
        )
    )
    ends = np.column_stack(
        (
            random.uniform(2.0, 18.0, branches),
            random.uniform(1.4, 3.0, branches) * random.choice((-1.0, 1.0), branches),
            random.uniform(-6.5, -3.5, branches),
        )
    )
    capsules = np.column_stack((ends, ends + random.uniform(-0.8, 0.8, (branches, 3)), np.full(branches, 0.03)))
    boxes = np.array(
        [[9.0, -3.4, 24.0, 0.3, 8.0, 0.0], [9.0, 3.4, 24.0, 0.3, 8.0, 0.0], [15.0, 0.0, 0.3, 7.0, 8.0, 0.0]],
    )
    return Scene(cylinders=cylinders, boxes=boxes, capsules=capsules)

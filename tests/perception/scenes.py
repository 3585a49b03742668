"""Scenes seen by a simulated depth camera, and what perception should make of them."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from flightapp.config.mission import Box, Cylinder, Obstacles
from flightapp.sim.world import World
from perception.geometry import CameraMounting, camera_pose
from perception.synthetic.depth_renderer import DepthRenderer
from perception.types import DepthFrame, Intrinsics, VehiclePose

D435 = Intrinsics(848, 480, 421.6, 421.6, 424.0, 240.0)
MOUNTING = CameraMounting(forward_m=0.1)


def pose(
    north: float = 0.0,
    east: float = 0.0,
    height: float = 5.0,
    roll_deg: float = 0.0,
    pitch_deg: float = 0.0,
    yaw_deg: float = 0.0,
) -> VehiclePose:
    angles = (math.radians(angle) for angle in (roll_deg, pitch_deg, yaw_deg))
    return VehiclePose((north, east, -height), (0.0, 0.0, 0.0), *angles)


class Stage:
    """A scene with a camera in it. `shoot` counts frames at 30 Hz."""

    def __init__(self, cylinders: list[tuple[float, ...]], boxes: list[tuple[float, ...]], noise: bool, seed: int) -> None:
        self.world = World(
            Obstacles(
                cylinders=tuple(Cylinder(north_m=n, east_m=e, radius_m=r, height_m=h) for n, e, r, h in cylinders),
                boxes=tuple(
                    Box(north_m=n, east_m=e, length_m=le, width_m=w, height_m=h, heading_deg=a) for n, e, le, w, h, a in boxes
                ),
            )
        )
        self.renderer = DepthRenderer(self.world, D435, noise=noise, seed=seed)
        self.number = 0

    def shoot(self, at: VehiclePose, spheres: np.ndarray | None = None) -> DepthFrame:
        self.number += 1
        depth = self.renderer.render(camera_pose(at, MOUNTING), self.number, spheres)
        return DepthFrame(self.number / 30, self.number, depth, 0.001, D435)


MakeStage = Callable[..., Stage]


def outside_m(points: np.ndarray, discs: np.ndarray) -> np.ndarray:
    """How far points (n, 2) lie outside the union of discs (k, >=3); negative inside."""
    gaps = np.hypot(points[:, :1] - discs[:, 0], points[:, 1:2] - discs[:, 1]) - discs[:, 2]
    return gaps.min(axis=1)


def visible_band(frame: DepthFrame, at: VehiclePose, band_m: float = 1.0) -> np.ndarray:
    """(n, 2) north, east of every surface point of a noise-free frame within the height band and above the ground."""
    camera = camera_pose(at, MOUNTING)
    v, u = np.nonzero(frame.depth)
    z = frame.depth[v, u] * frame.depth_unit_m
    k = frame.intrinsics
    optical = np.column_stack([(u - k.cx_px) / k.fx_px * z, (v - k.cy_px) / k.fy_px * z, z])
    points = optical @ camera.rotation.T + camera.position_ned_m
    inside = (np.abs(points[:, 2] - at.position_ned_m[2]) < band_m) & (points[:, 2] < -0.7)
    return points[inside, :2]

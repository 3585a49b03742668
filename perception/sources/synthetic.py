"""Frames of a known scene, seen from a vehicle on a given motion: what a camera would have delivered, with the true pose."""

from __future__ import annotations

from collections.abc import Callable

from perception.geometry import CameraMounting, MountingLike, camera_pose
from perception.sources.api import SourceHealth
from perception.synthetic.depth_renderer import DEPTH_UNIT_M, DepthRenderer
from perception.synthetic.scene import SceneLike
from perception.types import DepthFrame, Intrinsics, VehiclePose


class SyntheticSource:
    """Returns every frame once, one a call; frame k was taken at k / rate_hz. None from `duration_s` on.

    motion: time in s -> pose of the vehicle in the mission frame. noise, seed: see `DepthRenderer`.
    """

    def __init__(
        self,
        scene: SceneLike,
        intrinsics: Intrinsics,
        motion: Callable[[float], VehiclePose],
        *,
        mounting: MountingLike | None = None,
        rate_hz: float = 30.0,
        duration_s: float | None = None,
        range_min_m: float = 0.3,
        range_max_m: float = 10.0,
        noise: bool = True,
        seed: int = 0,
    ) -> None:
        self._renderer = DepthRenderer(
            scene, intrinsics, range_min_m=range_min_m, range_max_m=range_max_m, noise=noise, seed=seed
        )
        self._intrinsics = intrinsics
        self._motion = motion
        self._mounting = mounting if mounting is not None else CameraMounting()
        self._rate_hz = rate_hz
        self._duration_s = duration_s
        self._received = 0
        self._is_closed = False

    @property
    def health(self) -> SourceHealth:
        return SourceHealth(received=self._received)

    @property
    def is_finished(self) -> bool:
        is_over = self._duration_s is not None and self._received / self._rate_hz >= self._duration_s
        return is_over or self._is_closed

    def latest(self) -> DepthFrame | None:
        if self.is_finished:
            return None
        number = self._received
        t_s = number / self._rate_hz
        pose = self._motion(t_s)
        depth = self._renderer.render(camera_pose(pose, self._mounting), number)
        self._received += 1
        return DepthFrame(t_s, number, depth, DEPTH_UNIT_M, self._intrinsics, pose)

    def close(self) -> None:
        self._is_closed = True

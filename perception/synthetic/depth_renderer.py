"""What a depth camera of the RealSense D435 kind sees of a known scene.

Ray-casts the scene into an exact z-depth image (`surfaces`), makes it what stereo matching measures (`stereo`), and spoils it as
`flaws` say. The image is a function of (scene, pose, seed, frame number) alone.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from perception.geometry import CameraPose
from perception.synthetic.flaws import Flaws, spoil
from perception.synthetic.scene import Rows, SceneLike
from perception.synthetic.stereo import (
    BASELINE_M,
    DEPTH_UNIT_M,
    NOISE_1_M,
    NOISE_COLUMNS,
    NOISE_ROWS,
    depth_mm,
    empty_below,
    kept_below,
    match,
    measure,
    noise_tables,
    quantise,
)
from perception.synthetic.surfaces import draw_boxes, draw_capsules, draw_cylinders, draw_ground, draw_spheres
from perception.types import Intrinsics

__all__ = ["BASELINE_M", "DEPTH_UNIT_M", "DepthRenderer"]

GOOD_DAY = Flaws()


class DepthRenderer:
    """Renders one scene for one camera. Not safe for use from two threads at once.

    range_min_m, range_max_m: there is no return outside; the camera goes on far beyond where it is worth believing.
    noise: False for the exact geometry, without any flaw.
    """

    def __init__(
        self,
        scene: SceneLike,
        intrinsics: Intrinsics,
        *,
        range_min_m: float = 0.3,
        range_max_m: float = 30.0,
        noise: bool = True,
        seed: int = 0,
        flaws: Flaws = GOOD_DAY,
    ) -> None:
        self._scene = scene
        self._intrinsics = intrinsics
        self._range_min_m = range_min_m
        self._range_max_m = range_max_m
        self._is_noisy = noise
        self._seed = seed
        self._flaws = flaws
        self._disparity_1_m = intrinsics.fx_px * BASELINE_M
        self._z = np.zeros((intrinsics.height_px, intrinsics.width_px), np.float32)
        self._matched = np.zeros_like(self._z)
        rows, columns = NOISE_ROWS + intrinsics.height_px, NOISE_COLUMNS + intrinsics.width_px
        self._noise, self._rank = noise_tables(rows, columns, seed)
        self._mm_of_steps = depth_mm(self._disparity_1_m, range_min_m, range_max_m)
        self._empty_below = empty_below(self._disparity_1_m, range_min_m, flaws.hole_fraction)
        self._kept = kept_below(flaws.window_px)

    def render(self, camera: CameraPose, number: int, spheres: Rows | None = None) -> NDArray[np.uint16]:
        """z-depth (height, width) in mm as seen from `camera`, 0 = no return.

        number: frame number, picks the noise. spheres: (k, 4) north_m, east_m, down_m, radius_m of other vehicles.
        """
        self._draw(camera, spheres)
        out = np.empty(self._z.shape, np.uint16)
        if not self._is_noisy:
            quantise(self._z, out, self._range_min_m, self._range_max_m)
            return out
        random = np.random.default_rng((self._seed, number))
        corner = int(random.integers(NOISE_ROWS)), int(random.integers(NOISE_COLUMNS))
        sign = 1.0 if random.integers(2) else -1.0
        disparity = np.divide(np.float32(self._disparity_1_m), self._z, out=self._z)
        if self._flaws.window_px > 1:
            match(disparity, self._matched, self._noise, *corner, self._kept)
            disparity = self._matched
        sigma_px = sign * NOISE_1_M * self._disparity_1_m
        sky_px = 0.9 * self._disparity_1_m / self._range_max_m
        measure(disparity, out, self._noise, self._rank, *corner, sigma_px, sky_px, self._empty_below, self._mm_of_steps)
        spoil(out, self._flaws, self._intrinsics, camera, random)
        return out

    def _draw(self, camera: CameraPose, spheres: Rows | None) -> None:
        """The exact image in metres, 1e9 where there is nothing."""
        k, scene, far = self._intrinsics, self._scene, self._range_max_m
        lens = (k.fx_px, k.fy_px, k.cx_px, k.cy_px)
        rotation = np.ascontiguousarray(camera.rotation, np.float64)
        position = np.ascontiguousarray(camera.position_ned_m, np.float64)
        ground = scene.ground_down_m
        draw_ground(self._z, rotation, position, *lens, ground)
        draw_cylinders(self._z, rotation, position, *lens, ground, scene.cylinders, far)
        draw_boxes(self._z, rotation, position, *lens, ground, scene.boxes, far)
        draw_capsules(self._z, rotation, position, *lens, scene.capsules, far)
        if spheres is not None and len(spheres):
            draw_spheres(self._z, rotation, position, *lens, np.ascontiguousarray(spheres, np.float64), far)

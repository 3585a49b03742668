"""What a depth camera of the RealSense D435 kind sees of a known scene.

Ray-casts the ground plane, vertical cylinders, boxes and spheres into a z-depth image, then makes it look like stereo depth:

- Noise is in the disparity, so that the depth's standard deviation is 0.004 m * (distance in m)^2, i.e. 0.4 % at 1 m, 1.6 % at
  4 m, 4 % at 10 m: the published subpixel error of 0.08 px over a baseline of 50 mm at a focal length of 421.6 px. Half of it is
  white, half comes in blobs of a few pixels, as the matching window makes it.
- Disparity comes in steps of 1/32 px (Intel, "Subpixel Linearity Improvement for D400"; recorded frames show the same steps).
- Holes: about 1 % of the pixels return nothing, singly and in small clumps. Beyond 8 m the texture is seen ever more coarsely:
  the share of pixels that return falls linearly to a tenth at 30 m. So an open field is not all zero, and the open sky is.
- Shadows: left of a near edge the second imager does not see the background; those pixels return nothing. The shadow is as wide
  as the jump in disparity, focal length * baseline * (1 / near - 1 / far). For the same reason the left border of the picture,
  as wide as the disparity, returns nothing (D400 datasheet, "invalid depth band").
- Out of range (below `range_min_m`, beyond `range_max_m`) is 0. The camera goes on far beyond where it is worth believing.

The image is a function of (scene, pose, seed, frame number) alone.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numba
import numpy as np
from numpy.typing import NDArray

from perception.geometry import CameraPose
from perception.synthetic.scene import Rows, SceneLike
from perception.types import Intrinsics

DEPTH_UNIT_M = 0.001
NOISE_1_M = 0.004
BASELINE_M = 0.05
_STEPS_PER_PX = 32.0
_HOLE_FRACTION = 0.01
_FILL_FALLS_FROM_M = 8.0
_FILL_FALLS_TO_M = 30.0
_FILL_MIN = 0.1
_NOISE_SCALE = 32.0
_NOISE_ROWS, _NOISE_COLUMNS = 256, 512
_NEAR_M = 0.02
_SKY_M = 100.0
_DEPTH_MAX_MM = 65535
_SCALARS = "f8,f8,f8,f8"


class DepthRenderer:
    """Renders one scene for one camera. Not safe for use from two threads at once."""

    def __init__(
        self,
        scene: SceneLike,
        intrinsics: Intrinsics,
        *,
        range_min_m: float = 0.3,
        range_max_m: float = 30.0,
        noise: bool = True,
        seed: int = 0,
    ) -> None:
        self._scene = scene
        self._intrinsics = intrinsics
        self._range_min_m = range_min_m
        self._range_max_m = range_max_m
        self._is_noisy = noise
        self._seed = seed
        self._z = np.zeros((intrinsics.height_px, intrinsics.width_px), np.float32)
        rows, columns = _NOISE_ROWS + intrinsics.height_px, _NOISE_COLUMNS + intrinsics.width_px
        self._noise, self._rank = _noise_tables(rows, columns, seed)
        self._mm_of_steps = _depth_mm(intrinsics.fx_px * BASELINE_M, range_min_m, range_max_m)

    def render(self, camera: CameraPose, number: int, spheres: Rows | None = None) -> NDArray[np.uint16]:
        """z-depth (height, width) in mm as seen from `camera`, 0 = no return.

        number: frame number, picks the noise. spheres: (k, 4) north_m, east_m, down_m, radius_m of other vehicles.
        """
        k = self._intrinsics
        lens = (k.fx_px, k.fy_px, k.cx_px, k.cy_px)
        rotation = np.ascontiguousarray(camera.rotation, np.float64)
        position = np.ascontiguousarray(camera.position_ned_m, np.float64)
        ground = self._scene.ground_down_m
        _draw_ground(self._z, rotation, position, *lens, ground)
        _draw_cylinders(self._z, rotation, position, *lens, ground, self._scene.cylinders, self._range_max_m)
        _draw_boxes(self._z, rotation, position, *lens, ground, self._scene.boxes, self._range_max_m)
        if spheres is not None and len(spheres):
            _draw_spheres(self._z, rotation, position, *lens, np.ascontiguousarray(spheres, np.float64), self._range_max_m)
        out = np.empty(self._z.shape, np.uint16)
        if self._is_noisy:
            random = np.random.default_rng((self._seed, number))
            row, column = int(random.integers(_NOISE_ROWS)), int(random.integers(_NOISE_COLUMNS))
            sign = 1.0 if random.integers(2) else -1.0
            _measure(self._z, out, self._noise, self._rank, row, column, sign, k.fx_px * BASELINE_M, self._mm_of_steps)
        else:
            _quantise(self._z, out, self._range_min_m, self._range_max_m)
        return out


@lru_cache(maxsize=8)
def _noise_tables(rows: int, columns: int, seed: int) -> tuple[NDArray[np.int8], NDArray[np.uint8]]:
    """Unit noise in steps of 1/32; and for every pixel a number in 0..255: how readily it returns something."""
    random = np.random.default_rng(seed)
    white = random.standard_normal((rows, columns)).astype(np.float32)
    blobs = _smooth(random.standard_normal((rows, columns)).astype(np.float32))
    noise = (white + blobs / blobs.std()) * np.float32(math.sqrt(0.5))
    table: NDArray[np.int8] = np.clip(np.rint(noise * _NOISE_SCALE), -127, 127).astype(np.int8)
    clumps = _smooth(random.standard_normal((rows, columns)).astype(np.float32))
    clump_rank = np.empty(clumps.size, np.float32)
    clump_rank[np.argsort(clumps, axis=None)] = np.arange(clumps.size, dtype=np.float32) / np.float32(clumps.size)
    least = np.minimum(clump_rank.reshape(rows, columns), random.random((rows, columns), np.float32))
    # The lesser of two uniform numbers, made uniform again.
    return table, (256 * (1 - (1 - least) ** 2)).astype(np.uint8)


def _depth_mm(disparity_1_m: float, range_min_m: float, range_max_m: float) -> NDArray[np.uint16]:
    """Depth in mm for 0, 1, 2, ... steps of disparity up to the first beyond `range_min_m`; 0 out of range."""
    steps = np.arange(math.ceil(disparity_1_m * _STEPS_PER_PX / max(range_min_m, _NEAR_M)) + 2)
    depth_m = disparity_1_m * _STEPS_PER_PX / np.maximum(steps, 1e-9)
    inside = (depth_m >= range_min_m) & (depth_m <= min(range_max_m, _DEPTH_MAX_MM * DEPTH_UNIT_M))
    return np.where(inside, np.rint(depth_m / DEPTH_UNIT_M), 0).astype(np.uint16)


def _smooth(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """Mean over 5 x 5 pixels, wrapping around."""
    for axis in (0, 1):
        image = sum((np.roll(image, shift, axis) for shift in range(-2, 3)), np.zeros_like(image)) / np.float32(5)
    return image


@numba.njit("void(f4[:,::1],f8[:,::1],f8[::1]," + _SCALARS + ",f8)", cache=True, nogil=True, error_model="numpy")
def _draw_ground(z, rotation, position, fx, fy, cx, cy, ground):  # type: ignore[no-untyped-def]
    """Fill the image with the ground plane; 1e9 where the ray does not meet it."""
    height = ground - position[2]
    for v in range(z.shape[0]):
        row = rotation[2, 1] * (v - cy) / fy + rotation[2, 2]
        step = rotation[2, 0] / fx
        for u in range(z.shape[1]):
            down = row + step * (u - cx)
            z[v, u] = height / down if down > 1e-9 and height > 0 else 1e9


@numba.njit("UniTuple(i8,4)(f8[:,::1],f8[:,::1],f8[::1]," + _SCALARS + ",i8,i8,f8)", cache=True, nogil=True)
def _window(corners, rotation, position, fx, fy, cx, cy, width, height, range_max):  # type: ignore[no-untyped-def]
    """Pixels [u0, u1), [v0, v1) that can show a box with `corners` (8, 3), bit k of the index = far end of axis k."""
    x, y, depth = np.empty(8), np.empty(8), np.empty(8)
    nearest = 1e18
    for i in range(8):
        n, e, d = corners[i, 0] - position[0], corners[i, 1] - position[1], corners[i, 2] - position[2]
        x[i] = rotation[0, 0] * n + rotation[1, 0] * e + rotation[2, 0] * d
        y[i] = rotation[0, 1] * n + rotation[1, 1] * e + rotation[2, 1] * d
        depth[i] = rotation[0, 2] * n + rotation[1, 2] * e + rotation[2, 2] * d
        nearest = min(nearest, depth[i])
    u0, u1, v0, v1 = 1e18, -1e18, 1e18, -1e18
    if nearest <= range_max:
        for i in range(8):
            if depth[i] >= _NEAR_M:
                u, v = cx + fx * x[i] / depth[i], cy + fy * y[i] / depth[i]
                u0, u1, v0, v1 = min(u0, u), max(u1, u), min(v0, v), max(v1, v)
            for axis in range(3):
                j = i ^ (1 << axis)
                if depth[i] < _NEAR_M <= depth[j]:
                    part = (_NEAR_M - depth[i]) / (depth[j] - depth[i])
                    u = cx + fx * (x[i] + part * (x[j] - x[i])) / _NEAR_M
                    v = cy + fy * (y[i] + part * (y[j] - y[i])) / _NEAR_M
                    u0, u1, v0, v1 = min(u0, u), max(u1, u), min(v0, v), max(v1, v)
    if u1 < u0:
        return 0, 0, 0, 0
    left = int(min(max(math.floor(u0), 0.0), float(width)))
    right = int(min(max(math.ceil(u1) + 1.0, 0.0), float(width)))
    upper = int(min(max(math.floor(v0), 0.0), float(height)))
    lower = int(min(max(math.ceil(v1) + 1.0, 0.0), float(height)))
    return left, right, upper, lower


@numba.njit("void(f4[:,::1],f8[:,::1],f8[::1]," + _SCALARS + ",f8,f8[:,::1],f8)", cache=True, nogil=True, error_model="numpy")
def _draw_cylinders(z, rotation, position, fx, fy, cx, cy, ground, cylinders, range_max):  # type: ignore[no-untyped-def]
    """Vertical cylinders (n, 4) north, east, radius, height standing on the ground: sides and tops."""
    corners = np.empty((8, 3))
    for item in range(cylinders.shape[0]):
        north, east, radius = cylinders[item, 0], cylinders[item, 1], cylinders[item, 2]
        top = ground - cylinders[item, 3]
        for i in range(8):
            corners[i, 0] = north + (radius if i & 1 else -radius)
            corners[i, 1] = east + (radius if i & 2 else -radius)
            corners[i, 2] = ground if i & 4 else top
        u0, u1, v0, v1 = _window(corners, rotation, position, fx, fy, cx, cy, z.shape[1], z.shape[0], range_max)
        n, e = position[0] - north, position[1] - east
        c = n * n + e * e - radius * radius
        above = top - position[2]
        for v in range(v0, v1):
            y = (v - cy) / fy
            base_n = rotation[0, 1] * y + rotation[0, 2]
            base_e = rotation[1, 1] * y + rotation[1, 2]
            base_d = rotation[2, 1] * y + rotation[2, 2]
            for u in range(u0, u1):
                x = (u - cx) / fx
                ray_n = rotation[0, 0] * x + base_n
                ray_e = rotation[1, 0] * x + base_e
                ray_d = rotation[2, 0] * x + base_d
                a = ray_n * ray_n + ray_e * ray_e
                b = n * ray_n + e * ray_e
                inner = b * b - a * c
                if inner > 0.0 and a > 1e-12:
                    s = (-b - math.sqrt(inner)) / a
                    down = position[2] + s * ray_d
                    if s > _NEAR_M and top <= down <= ground and s < z[v, u]:
                        z[v, u] = s
                if above > 0.0 and ray_d > 1e-9:
                    s = above / ray_d
                    at_n, at_e = n + s * ray_n, e + s * ray_e
                    if s > _NEAR_M and at_n * at_n + at_e * at_e <= radius * radius and s < z[v, u]:
                        z[v, u] = s


@numba.njit("void(f4[:,::1],f8[:,::1],f8[::1]," + _SCALARS + ",f8,f8[:,::1],f8)", cache=True, nogil=True, error_model="numpy")
def _draw_boxes(z, rotation, position, fx, fy, cx, cy, ground, boxes, range_max):  # type: ignore[no-untyped-def]
    """Boxes (n, 6) north, east, length, width, height, heading_rad standing on the ground."""
    corners = np.empty((8, 3))
    for item in range(boxes.shape[0]):
        north, east = boxes[item, 0], boxes[item, 1]
        half_l, half_w = boxes[item, 2] / 2, boxes[item, 3] / 2
        top = ground - boxes[item, 4]
        cos, sin = math.cos(boxes[item, 5]), math.sin(boxes[item, 5])
        for i in range(8):
            along = half_l if i & 1 else -half_l
            across = half_w if i & 2 else -half_w
            corners[i, 0] = north + along * cos - across * sin
            corners[i, 1] = east + along * sin + across * cos
            corners[i, 2] = ground if i & 4 else top
        u0, u1, v0, v1 = _window(corners, rotation, position, fx, fy, cx, cy, z.shape[1], z.shape[0], range_max)
        n, e = position[0] - north, position[1] - east
        own_l, own_w = n * cos + e * sin, e * cos - n * sin
        # Rows of the rotation that takes optical axes to the axes of the box.
        to_l = rotation[0] * cos + rotation[1] * sin
        to_w = rotation[1] * cos - rotation[0] * sin
        for v in range(v0, v1):
            y = (v - cy) / fy
            for u in range(u0, u1):
                x = (u - cx) / fx
                ray_l = to_l[0] * x + to_l[1] * y + to_l[2]
                ray_w = to_w[0] * x + to_w[1] * y + to_w[2]
                ray_d = rotation[2, 0] * x + rotation[2, 1] * y + rotation[2, 2]
                ray_l = ray_l if abs(ray_l) > 1e-12 else 1e-12
                ray_w = ray_w if abs(ray_w) > 1e-12 else 1e-12
                ray_d = ray_d if abs(ray_d) > 1e-12 else 1e-12
                per_l, per_w, per_d = 1.0 / ray_l, 1.0 / ray_w, 1.0 / ray_d
                s0, s1 = (-half_l - own_l) * per_l, (half_l - own_l) * per_l
                enter, leave = min(s0, s1), max(s0, s1)
                s0, s1 = (-half_w - own_w) * per_w, (half_w - own_w) * per_w
                enter, leave = max(enter, min(s0, s1)), min(leave, max(s0, s1))
                s0, s1 = (top - position[2]) * per_d, (ground - position[2]) * per_d
                enter, leave = max(enter, min(s0, s1)), min(leave, max(s0, s1))
                if _NEAR_M < enter <= leave and enter < z[v, u]:
                    z[v, u] = enter


@numba.njit("void(f4[:,::1],f8[:,::1],f8[::1]," + _SCALARS + ",f8[:,::1],f8)", cache=True, nogil=True, error_model="numpy")
def _draw_spheres(z, rotation, position, fx, fy, cx, cy, spheres, range_max):  # type: ignore[no-untyped-def]
    """Spheres (n, 4) north, east, down, radius."""
    corners = np.empty((8, 3))
    for item in range(spheres.shape[0]):
        radius = spheres[item, 3]
        for i in range(8):
            for axis in range(3):
                corners[i, axis] = spheres[item, axis] + (radius if i >> axis & 1 else -radius)
        u0, u1, v0, v1 = _window(corners, rotation, position, fx, fy, cx, cy, z.shape[1], z.shape[0], range_max)
        n, e, d = position[0] - spheres[item, 0], position[1] - spheres[item, 1], position[2] - spheres[item, 2]
        c = n * n + e * e + d * d - radius * radius
        for v in range(v0, v1):
            y = (v - cy) / fy
            for u in range(u0, u1):
                x = (u - cx) / fx
                ray_n = rotation[0, 0] * x + rotation[0, 1] * y + rotation[0, 2]
                ray_e = rotation[1, 0] * x + rotation[1, 1] * y + rotation[1, 2]
                ray_d = rotation[2, 0] * x + rotation[2, 1] * y + rotation[2, 2]
                a = ray_n * ray_n + ray_e * ray_e + ray_d * ray_d
                b = n * ray_n + e * ray_e + d * ray_d
                inner = b * b - a * c
                if inner > 0.0:
                    s = (-b - math.sqrt(inner)) / a
                    if s > _NEAR_M and s < z[v, u]:
                        z[v, u] = s


@numba.njit("void(f4[:,::1],u2[:,::1],i1[:,::1],u1[:,::1],i8,i8,f4,f4,u2[::1])", cache=True, nogil=True, error_model="numpy")
def _measure(z, out, noise, rank, row, column, sign, disparity_1_m, mm_of_steps):  # type: ignore[no-untyped-def]
    """z-depth in m -> what a stereo camera reports in mm: noise, holes, shadows, range.

    mm_of_steps: depth for each number of disparity steps, 0 out of range.
    """
    width = z.shape[1]
    unit_px = np.float32(sign * NOISE_1_M / _NOISE_SCALE) * disparity_1_m
    steps_per_px = np.float32(_STEPS_PER_PX)
    fall_from = np.float32(_FILL_FALLS_FROM_M)
    holes = np.float32(256.0 * _HOLE_FRACTION)
    fall = np.float32(256.0 * (1.0 - _FILL_MIN) / (_FILL_FALLS_TO_M - _FILL_FALLS_FROM_M))
    sky = np.float32(_SKY_M)
    last = np.float32(mm_of_steps.shape[0] - 1)
    for v in range(z.shape[0]):
        shadow = np.float32(1e9)
        for k in range(width):
            u = width - 1 - k
            depth = z[v, u]
            if depth > sky:
                shadow = min(shadow, np.float32(u))
                out[v, u] = 0
                continue
            disparity = disparity_1_m / depth
            reach = np.float32(u) - disparity
            hidden = reach > shadow or reach < np.float32(0.0)
            shadow = min(shadow, reach)
            empty = holes + fall * max(depth - fall_from, np.float32(0.0))
            if hidden or np.float32(rank[row + v, column + u]) < empty:
                out[v, u] = 0
                continue
            steps = (disparity + unit_px * np.float32(noise[row + v, column + u])) * steps_per_px + np.float32(0.5)
            out[v, u] = mm_of_steps[int(max(min(steps, last), np.float32(0.0)))]


@numba.njit("void(f4[:,::1],u2[:,::1],f8,f8)", cache=True, nogil=True, error_model="numpy")
def _quantise(z, out, range_min, range_max):  # type: ignore[no-untyped-def]
    """z-depth in m -> mm, 0 out of range."""
    for v in range(z.shape[0]):
        for u in range(z.shape[1]):
            depth = z[v, u]
            out[v, u] = np.uint16(depth * 1000.0 + 0.5) if range_min <= depth <= range_max else 0

"""What a stereo camera of the D435 kind makes of an exact z-depth image. All compiled code of the measurement is here.

- Noise is in the disparity, so that the depth's standard deviation is 0.004 m * (distance in m)^2, i.e. 0.4 % at 1 m, 1.6 % at
  4 m, 4 % at 10 m: the published subpixel error of 0.08 px over a baseline of 50 mm at a focal length of 421.6 px. Half of it is
  white, half comes in blobs of a few pixels, as the matching window makes it.
- Disparity comes in steps of 1/32 px (Intel, "Subpixel Linearity Improvement for D400"; recorded frames show the same steps).
- Holes: about 1 % of the pixels return nothing, singly and in small clumps. Beyond 8 m texture is seen ever more coarsely: the
  share of pixels that return falls linearly to a tenth at 30 m (assumed). So an open field is not all zero; the open sky is.
- Shadows: left of a near edge the second imager does not see the background; those pixels return nothing. The shadow is as wide
  as the jump in disparity, focal length * baseline * (1 / near - 1 / far). For the same reason the left border of the picture,
  as wide as the disparity, returns nothing (D400 datasheet, "invalid depth band").
- Matching compares windows, not pixels: 7 px in the R200, to which the D400 adds edge-preserving filters (Keselman et al.,
  "Intel RealSense Stereoscopic Depth Cameras", 2017); 5 px are assumed here. At an edge the near surface grows into the far one,
  by 0 to 2 px and 1 px on average; of the outermost of these pixels three in ten fly, at the mean disparity of the two. What is
  narrower than the window is lost, along stretches of a few pixels, with the share of the window that it does not fill.
"""

from __future__ import annotations

import math
from functools import lru_cache
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from perception.kernel_cache import njit

DEPTH_UNIT_M = 0.001
NOISE_1_M = 0.004
BASELINE_M = 0.05
STEPS_PER_PX = 32.0
NOISE_ROWS, NOISE_COLUMNS = 256, 512
"""Every frame looks at the noise tables from a corner within this many rows and columns."""
_FILL_FALLS_FROM_M = 8.0
_FILL_FALLS_TO_M = 30.0
_FILL_MIN = 0.1
_NOISE_SCALE = 32.0
_DEPTH_MAX_MM = 65535
_EDGE_PX = 1.0
"""Neighbours whose disparities differ by more than this lie on different surfaces."""
_FLYING_OF_16 = 5
_GROWTH_PX, _GROWTH_SIGMA_PX = 1.0, 0.7


@lru_cache(maxsize=8)
def noise_tables(rows: int, columns: int, seed: int) -> tuple[NDArray[np.int8], NDArray[np.uint8]]:
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


def depth_mm(disparity_1_m: float, range_min_m: float, range_max_m: float) -> NDArray[np.uint16]:
    """Depth in mm for 0, 1, 2, ... steps of disparity up to the first beyond `range_min_m`; 0 out of range."""
    depth_m = _depth_m(disparity_1_m, range_min_m)
    inside = (depth_m >= range_min_m) & (depth_m <= min(range_max_m, _DEPTH_MAX_MM * DEPTH_UNIT_M))
    return np.where(inside, np.rint(depth_m / DEPTH_UNIT_M), 0).astype(np.uint16)


def empty_below(disparity_1_m: float, range_min_m: float, hole_fraction: float) -> NDArray[np.int16]:
    """Of 256 pixels, how many return nothing, for as many steps of disparity as in `depth_mm`."""
    beyond = (_depth_m(disparity_1_m, range_min_m) - _FILL_FALLS_FROM_M) / (_FILL_FALLS_TO_M - _FILL_FALLS_FROM_M)
    share = hole_fraction + (1.0 - _FILL_MIN) * np.maximum(beyond, 0.0)
    of_256: NDArray[np.int16] = np.rint(256 * np.minimum(share, 1.0)).astype(np.int16)
    return of_256


def _depth_m(disparity_1_m: float, range_min_m: float) -> NDArray[np.float64]:
    steps = np.arange(math.ceil(disparity_1_m * STEPS_PER_PX / range_min_m) + 2)
    return disparity_1_m * STEPS_PER_PX / np.maximum(steps, 1e-9)


def kept_below(window_px: int) -> NDArray[np.int16]:
    """(window_px,) for something 0, 1, ... pixels wide: it is seen where the noise table is below this."""
    share = [width / window_px for width in range(window_px)]
    normal = NormalDist()
    return np.array([round(_NOISE_SCALE * normal.inv_cdf(one)) if one > 0.0 else -128 for one in share], np.int16)


def _smooth(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """Mean over 5 x 5 pixels, wrapping around."""
    for axis in (0, 1):
        image = sum((np.roll(image, shift, axis) for shift in range(-2, 3)), np.zeros_like(image)) / np.float32(5)
    return image


@njit("void(f4[:,::1],f4[:,::1],i1[:,::1],i8,i8,i2[::1],i8,i8)", cache=True, nogil=True, error_model="numpy")
def _match_along(exact, matched, noise, row, column, kept, down, right):  # type: ignore[no-untyped-def]
    """Lose thin things and let near edges grow along one direction, (down, right) = (0, 1) or (1, 0); see the module's text."""
    height, width = exact.shape
    window = kept.shape[0]
    edge = np.float32(_EDGE_PX)
    growth_sigma = np.float32(_GROWTH_SIGMA_PX / _NOISE_SCALE)
    for v in range(down, height):
        for u in range(right, width):
            before, here = exact[v - down, u - right], exact[v, u]
            if abs(here - before) <= edge:
                continue
            unit = noise[row + v, column + u]
            room = (height - v) if down else (width - u)
            if here > before:
                thickness, longest = 1, min(window, room)
                while thickness < longest:
                    beyond = exact[v + thickness * down, u + thickness * right]
                    if exact[v + (thickness - 1) * down, u + (thickness - 1) * right] - beyond > edge:
                        break
                    thickness += 1
                if thickness < longest and unit >= kept[thickness]:
                    behind = max(before, exact[v + thickness * down, u + thickness * right])
                    for k in range(thickness):
                        matched[v + k * down, u + k * right] = behind
                    continue
                near, far, away, room = here, before, -1, v if down else u
                first_v, first_u = v - down, u - right
            else:
                if matched[v - down, u - right] < before:
                    continue
                near, far, away = before, here, 1
                first_v, first_u = v, u
            growth = np.float32(_GROWTH_PX + 0.5) + growth_sigma * np.float32(unit)
            pixels = min(int(max(growth, np.float32(0.0))), window // 2, room)
            for k in range(pixels):
                is_flying = k == pixels - 1 and unit & 15 < _FLYING_OF_16
                value = np.float32(0.5) * (near + far) if is_flying else near
                at_v, at_u = first_v + k * away * down, first_u + k * away * right
                matched[at_v, at_u] = max(matched[at_v, at_u], value)


@njit("void(f4[:,::1],f4[:,::1],i1[:,::1],i8,i8,i2[::1])", cache=True, nogil=True, error_model="numpy")
def match(exact, matched, noise, row, column, kept):  # type: ignore[no-untyped-def]
    """Disparities in px as a matching window of `kept.shape[0]` pixels finds them, into `matched`."""
    matched[:] = exact
    _match_along(exact, matched, noise, row, column, kept, 0, 1)
    _match_along(exact, matched, noise, row, column, kept, 1, 0)


@njit("void(f4[:,::1],u2[:,::1],i1[:,::1],u1[:,::1],i8,i8,f4,f4,i2[::1],u2[::1])", cache=True, nogil=True, error_model="numpy")
def measure(disparity, out, noise, rank, row, column, sigma_px, sky_px, empty_below, mm_of_steps):  # type: ignore[no-untyped-def]
    """Disparity in px -> what a stereo camera reports in mm: noise, holes, shadows, range.

    sigma_px: of the noise, negative = upside down. sky_px: what has less disparity returns nothing. empty_below: for each number
    of disparity steps, the rank up to which pixels return nothing. mm_of_steps: depth for each number of disparity steps, 0 out
    of range.
    """
    width = disparity.shape[1]
    unit_steps = sigma_px * np.float32(STEPS_PER_PX / _NOISE_SCALE)
    last = np.int32(mm_of_steps.shape[0] - 1)
    for v in range(disparity.shape[0]):
        shadow = np.float32(1e9)
        for u in range(width - 1, -1, -1):
            px = disparity[v, u]
            reach = np.float32(u) - px
            hidden = reach > shadow or reach < np.float32(0.0)
            shadow = min(shadow, reach)
            if hidden or px < sky_px:
                out[v, u] = 0
                continue
            steps = px * np.float32(STEPS_PER_PX)
            if rank[row + v, column + u] < empty_below[min(np.int32(steps), last)]:
                out[v, u] = 0
                continue
            found = np.int32(steps + unit_steps * np.float32(noise[row + v, column + u]) + np.float32(0.5))
            out[v, u] = mm_of_steps[max(min(found, last), np.int32(0))]


@njit("void(f4[:,::1],u2[:,::1],f8,f8)", cache=True, nogil=True, error_model="numpy")
def quantise(z, out, range_min, range_max):  # type: ignore[no-untyped-def]
    """z-depth in m -> mm, 0 out of range."""
    for v in range(z.shape[0]):
        for u in range(z.shape[1]):
            depth = z[v, u]
            out[v, u] = np.uint16(depth * 1000.0 + 0.5) if range_min <= depth <= range_max else 0

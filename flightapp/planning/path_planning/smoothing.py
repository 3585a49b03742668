"""A path of few corners made short and round without coming nearer to a body (specification, section 2.3.4)."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from flightapp.core.types import Array
from flightapp.planning.path_planning.api import way_length_m
from flightapp.space.world import World

SHORTCUT_STEP_M = 2.0
SAMPLE_M = 0.25
SIGMA_M = 1.5
SIGMA_MIN_M = 0.1
PASSES = 2


def shortened(world: World, points: Array, gap_m: float) -> Array:
    """The polyline (k, 3) with straight ways where they keep `gap_m`: from each place to the last one that it can reach."""
    for _ in range(PASSES):
        places = sampled(points, SHORTCUT_STEP_M)
        kept, here = [0], 0
        while here < len(places) - 1:
            ahead = len(places) - 1
            while ahead > here + 1 and not world.is_way_free(places[here], places[ahead], gap_m):
                ahead -= 1
            kept.append(ahead)
            here = ahead
        points = places[kept]
    return points


def rounded(world: World, points: Array, gap_m: float) -> tuple[Array, float]:
    """(places (n, 3) at most SAMPLE_M apart, sigma in m): a Gaussian over the length takes the corners off.

    The ends stay, as the path goes on mirrored in them. Where the round way would come nearer than `gap_m` to a body, sigma is
    halved; in the end the corners stay, and sigma is 0.
    """
    places = sampled(points, SAMPLE_M)
    spacing = way_length_m(places) / max(1, len(places) - 1)
    sigma = SIGMA_M
    while sigma >= SIGMA_MIN_M and spacing > 0.0:
        smooth = _filtered(places, sigma / spacing)
        if all(world.is_way_free(one, other, gap_m) for one, other in pairwise(smooth)):
            return smooth, sigma
        sigma *= 0.5
    return places, 0.0


def sampled(points: Array, spacing_m: float) -> Array:
    """The polyline (k, 3) as places (n, 3) at most `spacing_m` apart: its corners, and each piece divided evenly."""
    pieces = [points[:1]]
    for start, end in pairwise(points):
        count = max(1, math.ceil(math.dist(start, end) / spacing_m))
        pieces.append(start + np.linspace(0.0, 1.0, count + 1)[1:, None] * (end - start))
    return np.vstack(pieces)


def _filtered(places: Array, sigma: float) -> Array:
    """`places` (n, 3) weighed by a Gaussian of `sigma` samples, continued point-symmetrically beyond both ends."""
    reach = min(len(places) - 1, math.ceil(4.0 * sigma))
    if reach < 1:
        return places
    before = 2.0 * places[0] - places[reach:0:-1]
    after = 2.0 * places[-1] - places[-2 : -reach - 2 : -1]
    extended = np.vstack((before, places, after))
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    weights /= weights.sum()
    smooth = np.stack([np.convolve(extended[:, axis], weights, mode="valid") for axis in range(3)], axis=1)
    smooth[0], smooth[-1] = places[0], places[-1]
    return smooth

"""`oavc`: the centroid of the safety cell, weighted by how much there is to learn of the evader.

After Pierson and Rus, "Distributed target tracking in cluttered environments with guaranteed collision avoidance" (2017): cells
of mates and obstacles alone, neither the evader's plane nor a box. The density is Gaussian around the evader; its width is ours.
"""

from __future__ import annotations

import numpy as np

from flightapp.planning.encirclement.moment import Moment
from flightapp.planning.plane import Point

SAMPLES = 24
"""A side of the square of samples."""
REACH_SIGMA = 5.0
"""The square reaches this many widths from the evader."""


class InformationCentroid:
    """Quadrature over a square of samples around the evader, those outside of the safety cell left out."""

    def __init__(self, sigma_m: float) -> None:
        middles = (np.arange(SAMPLES) + 0.5) / SAMPLES * 2.0 - 1.0
        offsets = np.stack(np.meshgrid(middles, middles, indexing="ij"), axis=-1).reshape(-1, 2)
        self._offsets = REACH_SIGMA * sigma_m * offsets
        self._exponents = -0.5 * (self._offsets**2).sum(axis=1) / sigma_m**2

    def __call__(self, moment: Moment) -> Point:
        situation = moment.situation
        places = self._offsets + np.array(moment.evader)
        planes = situation.planes[: situation.plane_count]
        inside = ((places - np.array(situation.own)) @ planes[:, :2].T <= planes[:, 2]).all(axis=1)
        if not inside.any():
            return moment.safe(moment.evader)
        exponents = self._exponents[inside]
        weights = np.exp(exponents - exponents.max())  # else far from the evader all weights are 0
        n, e = weights @ places[inside] / weights.sum()
        return float(n), float(e)

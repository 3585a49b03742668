"""Weighted sum of raw scores over the admissible candidates."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from flightapp.core.types import Array


def weighted(
    scores: Mapping[str, Array], weights: Mapping[str, float], admissible: NDArray[np.intp], *, raw: bool = False
) -> Array:
    """Total score (k,) of the k candidates with the indices `admissible`.

    Each score is normalised to [0, 1] over the admissible candidates before weighting, and counts nothing where all are
    equal; `raw` weights the plain values, as the source does.
    """
    total = np.zeros(len(admissible))
    for name, weight in weights.items():
        if weight == 0.0:
            continue
        score = scores[name][admissible]
        if raw:
            total += weight * score
            continue
        low = score.min()
        span = score.max() - low
        if span > 1e-12:
            total += (weight / span) * (score - low)
    return total

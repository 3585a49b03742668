"""Weighted sum of raw scores over the admissible candidates."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from flightapp.core.compiled import compiled
from flightapp.core.types import Array


@compiled("i8(f8[:,::1],f8[::1],i8[::1],b1,f8[::1])")
def best_candidate(scores: Array, weights: Array, verdicts: NDArray[np.int64], raw: bool, totals: Array) -> int:
    """Index of the admissible candidate (verdict 0) with the highest weighted score, the first of equals; -1: there is none.

    Each term, a row of scores (terms, n), is normalised to [0, 1] over the admissible candidates before weighting, and counts
    nothing where all are equal; `raw` weights the plain values, as the source does. totals (n,): the weighted sums.
    """
    count = verdicts.shape[0]
    for c in range(count):
        totals[c] = 0.0
    for term in range(scores.shape[0]):
        weight = weights[term]
        if weight == 0.0:
            continue
        score = scores[term]
        low = 0.0
        scale = weight
        if not raw:
            low = math.inf
            high = -math.inf
            for c in range(count):
                if verdicts[c] == 0:
                    low = min(low, score[c])
                    high = max(high, score[c])
            if high - low <= 1e-12:
                continue
            scale = weight / (high - low)
        for c in range(count):
            totals[c] += scale * (score[c] - low)
    best = -1
    for c in range(count):
        if verdicts[c] == 0 and (best < 0 or totals[c] > totals[best]):
            best = c
    return best

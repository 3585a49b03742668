"""Arrays for a page: what a person can see of them, as base64 of little-endian numbers that scripts read as typed arrays."""

from __future__ import annotations

import base64

import numpy as np

from flightapp.core.types import Array

PackedArray = dict[str, str]
"""`dtype` (f4, i4) and `bdata`, as plotly.js reads them too."""


def packed(values: Array, dtype: str = "f4") -> PackedArray:
    """One flat array; single precision holds a tenth of a millisecond over 20 minutes, a millimetre over kilometres."""
    content = np.ascontiguousarray(values, dtype=f"<{dtype}").tobytes()
    return {"dtype": dtype, "bdata": base64.b64encode(content).decode()}


def thinned(t_s: Array, values: Array, points_max: int) -> tuple[Array, Array]:
    """At most `points_max` points that look the same: of each stretch of time its smallest and its largest value.

    Stretches in which nothing is known leave a gap (NaN).
    """
    if len(t_s) <= points_max:
        return t_s, values
    edges = np.linspace(0, len(t_s), points_max // 2 + 1).astype(np.int64)
    known = np.isfinite(values)
    least = np.minimum.reduceat(np.where(known, values, np.inf), edges[:-1])
    greatest = np.maximum.reduceat(np.where(known, values, -np.inf), edges[:-1])
    any_known = np.isfinite(least)
    chosen_t = np.column_stack([t_s[edges[:-1]], t_s[(edges[:-1] + edges[1:]) // 2]])
    chosen = np.where(any_known[:, None], np.column_stack([least, greatest]), np.nan)
    return chosen_t.ravel(), chosen.ravel()


def spread_out(t_s: Array, step_s: float) -> Array:
    """Places (m,) of samples at least about `step_s` apart; the first and the last are among them."""
    if len(t_s) == 0:
        return np.zeros(0, dtype=np.int64)
    slot = np.floor((t_s - t_s[0]) / step_s + 1e-6)
    first = np.flatnonzero(np.diff(slot, prepend=-1.0) > 0)
    return np.unique(np.append(first, len(t_s) - 1))

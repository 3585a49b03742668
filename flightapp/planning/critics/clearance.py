"""Clearance: distance to the nearest obstacle, up to a saturation."""

from __future__ import annotations

import numpy as np

from flightapp.core.types import Array


def clearance(clearances_m: Array, saturation_m: float, out: Array) -> None:
    """Fill out (n,): min(clearance, saturation) in m; clearances_m (n,) over each candidate's whole way."""
    np.minimum(clearances_m, saturation_m, out=out)

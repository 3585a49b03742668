"""Clearance: distance to the nearest obstacle, up to a saturation."""

from __future__ import annotations

import numpy as np

from flightapp.core.types import Array


def clearance(clearances_m: Array, saturation_m: float) -> Array:
    """min(clearance, saturation) in m, (n,); clearances_m (n,) over each candidate's whole way."""
    return np.minimum(clearances_m, saturation_m)

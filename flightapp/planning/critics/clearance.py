"""Clearance: distance to the nearest obstacle, up to a saturation."""

from __future__ import annotations

from flightapp.core.compiled import compiled
from flightapp.core.types import Array


@compiled("void(f8[::1],f8,f8[::1])")
def clearance_score(clearances_m: Array, saturation_m: float, out: Array) -> None:
    """Fill out (n,): min(clearance, saturation) in m; clearances_m (n,) over each candidate's whole way."""
    for c in range(out.shape[0]):
        out[c] = clearances_m[c] if clearances_m[c] < saturation_m else saturation_m

"""Gains as the flat array that a kernel reads."""

from __future__ import annotations

from dataclasses import astuple, dataclass

import numpy as np

from flightapp.core.types import Array


@dataclass(frozen=True, slots=True)
class FlatGains:
    """Gains in the order of a kernel's array."""

    def as_array(self) -> Array:
        """(number of fields,) float64."""
        return np.array(astuple(self), dtype=np.float64)

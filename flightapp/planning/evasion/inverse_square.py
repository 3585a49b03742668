"""Evader policy `inverse-square`: away from all pursuers, from each with the inverse square of its distance."""

from __future__ import annotations

import numpy as np

from flightapp.core.types import Array, Limits
from flightapp.planning.api import Given, Planner
from flightapp.planning.evasion.parameters import ReactingParameters
from flightapp.planning.evasion.reacting import Reacting
from flightapp.planning.parameters import parsed
from flightapp.planning.plane import Point

PARAMETERS = ReactingParameters
NEAREST_M = 0.01
"""A smaller distance counts as this."""


def repelled(own: Point, pursuers: Array) -> Point:
    """Sum of the repulsions of `pursuers` (k > 0, 4)."""
    away = np.array(own) - pursuers[:, :2]
    distances = np.maximum(np.hypot(away[:, 0], away[:, 1]), NEAREST_M)
    n, e = (away / distances[:, None] ** 3).sum(axis=0)
    return float(n), float(e)


def build(name: str, limits: Limits, given: Given, _seed: int) -> Planner:
    """As the registry asks for it."""
    return Reacting(name, limits, parsed(ReactingParameters, name, given), repelled)

"""Evader policy `gap-runner`: through the middle of the best gap between pursuers, before an encirclement closes it."""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.angles import TWO_PI
from flightapp.core.types import Array, Limits
from flightapp.planning.api import Given, Planner
from flightapp.planning.evasion.parameters import ReactingParameters
from flightapp.planning.evasion.reacting import Reacting
from flightapp.planning.parameters import parsed
from flightapp.planning.plane import Point

PARAMETERS = ReactingParameters
NEAREST_M = 0.01


def best_gap(own: Point, pursuers: Array) -> Point:
    """Where the gap between neighbours is widest, weighted by how near they are: a wide gap far away will have closed.

    pursuers: (k > 0, 4).
    """
    offsets = pursuers[:, :2] - np.array(own)
    bearings = np.arctan2(offsets[:, 1], offsets[:, 0])
    order = np.argsort(bearings, kind="stable")
    bearings, distances = bearings[order], np.hypot(offsets[order, 0], offsets[order, 1])
    gaps = np.diff(bearings, append=bearings[0] + TWO_PI)
    reach = np.maximum(0.5 * (distances + np.roll(distances, -1)), NEAREST_M)
    best = int((gaps / reach).argmax())
    middle = float(bearings[best] + 0.5 * gaps[best])
    return math.cos(middle), math.sin(middle)


def build(name: str, limits: Limits, given: Given, _seed: int) -> Planner:
    """As the registry asks for it."""
    return Reacting(name, limits, parsed(ReactingParameters, name, given), best_gap)

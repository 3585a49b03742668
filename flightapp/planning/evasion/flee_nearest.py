"""Evader policy `flee-nearest`: straight away from the nearest pursuer."""

from __future__ import annotations

import math

from flightapp.core.types import Array, Limits
from flightapp.planning.api import Given, Planner
from flightapp.planning.evasion.parameters import ReactingParameters
from flightapp.planning.evasion.reacting import Reacting
from flightapp.planning.parameters import parsed
from flightapp.planning.plane import Point

PARAMETERS = ReactingParameters


def away_from_nearest(own: Point, pursuers: Array) -> Point:
    """Away from the nearest of `pursuers` (k > 0, 4)."""
    n, e = min(((float(row[0]), float(row[1])) for row in pursuers), key=lambda place: math.dist(own, place))
    return own[0] - n, own[1] - e


def build(name: str, limits: Limits, given: Given, _seed: int) -> Planner:
    """As the registry asks for it."""
    return Reacting(name, limits, parsed(ReactingParameters, name, given), away_from_nearest)

"""`greedy`: the point of the safety cell nearest to the evader. In no paper, and the one to beat."""

from __future__ import annotations

from flightapp.planning.encirclement.moment import Moment
from flightapp.planning.plane import Point


def nearest_to_evader(moment: Moment) -> Point:
    return moment.safe(moment.evader)

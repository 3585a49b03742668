"""Evader policy `goal-seeker`: to a goal, weakly away from near pursuers."""

from __future__ import annotations

import math

from flightapp.core.types import Array, Limits
from flightapp.planning.api import Given, Planner
from flightapp.planning.evasion.parameters import GoalSeekerParameters
from flightapp.planning.evasion.reacting import Reacting
from flightapp.planning.parameters import parsed
from flightapp.planning.plane import Point, towards


class GoalDirection:
    """At the goal it stands, unless a pursuer is near."""

    def __init__(self, parameters: GoalSeekerParameters) -> None:
        self._parameters = parameters

    def __call__(self, own: Point, pursuers: Array) -> Point:
        parameters = self._parameters
        goal = parameters.goal_m
        n, e = towards(own, goal) if math.dist(own, goal) > parameters.arrival_m else (0.0, 0.0)
        for place_n, place_e, _, _ in pursuers.tolist():
            nearness = 1.0 - math.dist(own, (place_n, place_e)) / parameters.pursuer_influence_m
            if nearness > 0.0:
                push = towards((place_n, place_e), own)
                n += parameters.pursuer_gain * nearness * push[0]
                e += parameters.pursuer_gain * nearness * push[1]
        return n, e


PARAMETERS = GoalSeekerParameters


def build(name: str, limits: Limits, given: Given, _seed: int) -> Planner:
    """As the registry asks for it."""
    parameters = parsed(GoalSeekerParameters, name, given)
    return Reacting(name, limits, parameters, GoalDirection(parameters))

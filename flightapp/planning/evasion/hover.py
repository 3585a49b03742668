"""Evader policy `hover`: stands still."""

from __future__ import annotations

from flightapp.core.types import Decision, Limits, Observation
from flightapp.planning.api import Given, Planner
from flightapp.planning.evasion.command import decision
from flightapp.planning.evasion.parameters import HoverParameters
from flightapp.planning.parameters import parsed


class Hover:
    """Commands zero velocity."""

    def __init__(self, *, limits: Limits) -> None:
        self._speed_max_m_s = limits.speed_max_m_s

    def reset(self, seed: int | None = None) -> None:
        """Nothing to forget."""
        del seed

    def step(self, observation: Observation) -> Decision:
        return decision(observation, (0.0, 0.0), None, "hover", self._speed_max_m_s)


def build(name: str, limits: Limits, given: Given, _seed: int) -> Planner:
    """As the registry asks for it."""
    parsed(HoverParameters, name, given)
    return Hover(limits=limits)

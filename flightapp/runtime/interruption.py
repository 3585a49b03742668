"""How a mission ends early: the one action that follows, and the exception that carries it."""

from __future__ import annotations

from enum import Enum

from flightapp.runtime.outcome import Outcome
from flightapp.safety.failsafe.table import State


class Next(Enum):
    """What follows an interrupted mission."""

    RETURN = "return"
    """Fly home and land: the autopilot's return mode."""
    LAND = "land"
    """Land where the vehicle is."""
    TERMINATE = "terminate"
    """End the flight at once, whatever becomes of the vehicle."""
    RELEASE = "release"
    """Leave the vehicle to the pilot or to the autopilot's own failsafe; watch and record until it is disarmed."""


ACTIONS = {
    State.RETURN: Next.RETURN,
    State.LAND: Next.LAND,
    State.TERMINATE: Next.TERMINATE,
    State.PILOT: Next.RELEASE,
}
"""The failsafe states that end a mission."""
DOING = {action: state for state, action in ACTIONS.items()} | {Next.RELEASE: State.NORMAL}
"""A vehicle that somebody else flies is not being ended by the app: any wish counts again."""


class InterruptedMission(Exception):  # noqa: N818 - control flow, not an error
    """The mission ends now."""

    def __init__(self, action: Next, outcome: Outcome, reason: str) -> None:
        super().__init__(reason)
        self.action = action
        self.outcome = outcome
        self.reason = reason

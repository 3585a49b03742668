"""How a pursuit ends, and who decides when vehicles say different things."""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum


class Outcome(StrEnum):
    """Result of one mission as one vehicle knows it."""

    CAPTURED = "captured"
    """The success criterion was met."""
    ESCAPED = "escaped"
    """The evader crossed the boundary."""
    TIMEOUT = "timeout"
    """The time limit passed first."""
    ABORTED = "aborted"
    """A person, or the pilot's transmitter, ended it."""
    FAULT = "fault"
    """Something failed."""


EXIT_STATUS = {
    Outcome.CAPTURED: 0,
    Outcome.ESCAPED: 1,
    Outcome.TIMEOUT: 1,
    Outcome.ABORTED: 1,
    Outcome.FAULT: 3,
}
"""What a process that flew a mission ends with."""


def outcome_of_team(outcomes: Iterable[str | None]) -> Outcome | None:
    """What the others' reports mean for this vehicle's pursuit; an abort or fault of one does not end it for all."""
    told = set(outcomes)
    for outcome in (Outcome.CAPTURED, Outcome.ESCAPED, Outcome.TIMEOUT):
        if outcome in told:
            return outcome
    return None

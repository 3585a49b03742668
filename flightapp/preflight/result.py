"""What a check says: one of seven levels, what was found, why it matters, what to do."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class Level(IntEnum):
    """By rising trouble."""

    PASSED = 0
    NOTED = 1
    """Fine, and worth reading."""
    SKIPPED = 2
    """Does not apply to this vehicle, mission or autopilot version."""
    WAIVED = 3
    """Failed, and somebody said by name to fly all the same."""
    WARNING = 4
    """Will fly; somebody should know before."""
    RUNNING = 5
    """Not yet: it converges by itself. Wait."""
    FAILED = 6
    """Does not fly."""

    @property
    def word(self) -> str:
        return self.name.lower()


@dataclass(frozen=True, slots=True)
class Result:
    """Of one check. `remedy` is empty where nothing needs to be done."""

    check: str
    level: Level
    found: str
    reason: str
    remedy: str = ""


def is_ready(results: list[Result]) -> bool:
    """Whether the vehicle may be armed."""
    return all(result.level < Level.RUNNING for result in results)

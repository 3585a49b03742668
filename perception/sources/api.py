"""What perception needs of a camera."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from perception.types import DepthFrame


@dataclass(frozen=True, slots=True)
class SourceHealth:
    """Counters since the source was opened, and its state now."""

    received: int = 0
    """Frames returned by `latest`."""
    skipped: int = 0
    """Frames that arrived but nobody saw, because a newer one was there."""
    lost: int = 0
    """Frames that the camera took but that never arrived: gaps in its frame numbers."""
    restarts: int = 0
    """How often a stalled stream was started again."""
    temperature_c: float | None = None
    fault: str = ""
    """What is wrong now, one sentence; empty while frames come."""
    warning: str = ""
    """What should be put right although frames come, one sentence: a camera on USB 2."""


class DepthSource(Protocol):
    """A source of depth frames that is polled and never blocks."""

    @property
    def health(self) -> SourceHealth:
        """Counters and state, as of the last call of `latest`."""

    @property
    def is_finished(self) -> bool:
        """True once a recording has come to its end; a camera never does."""

    def latest(self) -> DepthFrame | None:
        """The newest frame that was not returned yet (of a recording: the next one); None if there is nothing new.

        The pixels belong to the source: they stay unchanged until the second-next frame is returned.
        """

    def close(self) -> None:
        """Give the camera back."""

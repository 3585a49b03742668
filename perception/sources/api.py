"""What perception needs of a camera."""

from __future__ import annotations

from typing import Protocol

from perception.types import DepthFrame


class DepthSource(Protocol):
    """A source of depth frames that is polled and never blocks."""

    @property
    def received(self) -> int:
        """Frames returned so far."""

    @property
    def skipped(self) -> int:
        """Frames that the camera delivered but nobody saw, because a newer one was there."""

    def latest(self) -> DepthFrame | None:
        """The newest frame that was not returned yet; None if there is nothing new.

        The pixels belong to the source: they stay unchanged until the second-next frame is returned.
        """

    def close(self) -> None:
        """Give the camera back."""

"""The phases of one vehicle's mission, and the windows that the metrics are measured in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from flightapp.recording.reader import Recording

AIRBORNE = ("takeoff", "ingress", "ready", "pursue", "return", "land", "released")
OFFBOARD = ("ingress", "pursue", "return")


class Window(NamedTuple):
    """A span of fleet time, both ends included, s."""

    start_s: float
    end_s: float

    @property
    def length_s(self) -> float:
        return self.end_s - self.start_s

    def common(self, other: Window) -> Window | None:
        """What both windows have in common; None if nothing."""
        start_s, end_s = max(self.start_s, other.start_s), min(self.end_s, other.end_s)
        return Window(start_s, end_s) if start_s < end_s else None


@dataclass(frozen=True, slots=True)
class Phases:
    """Starts of the phases in order, `(t_s, phase)`; the last one ends with the recording."""

    starts: tuple[tuple[float, str], ...]
    end_s: float
    outcome: str | None
    outcome_s: float | None
    """When the outcome was first known."""

    def window(self, names: tuple[str, ...]) -> Window | None:
        """From the first start of any of `names` to the first start of another phase after the last of them."""
        inside = [index for index, (_, phase) in enumerate(self.starts) if phase in names]
        if not inside:
            return None
        after = inside[-1] + 1
        end_s = self.starts[after][0] if after < len(self.starts) else self.end_s
        start_s = self.starts[inside[0]][0]
        return Window(start_s, end_s) if end_s > start_s else None


def phases_of(recording: Recording) -> Phases:
    """Read the `/phase` messages; a repeated message of the same phase (the outcome became known) starts no new one."""
    series = recording.topic("/phase")
    starts: list[tuple[float, str]] = []
    outcome: str | None = None
    outcome_s: float | None = None
    for t_s, message in zip(series.t_s.tolist(), series.messages, strict=True):
        phase = str(message.get("phase"))
        if not starts or starts[-1][1] != phase:
            starts.append((t_s, phase))
        if message.get("outcome") is not None and outcome != message["outcome"]:
            outcome, outcome_s = str(message["outcome"]), t_s
    end_s = max((float(one.t_s[-1]) for one in recording.series.values() if len(one)), default=0.0)
    return Phases(tuple(starts), end_s, outcome, outcome_s)

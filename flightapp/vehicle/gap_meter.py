"""How evenly setpoints go out: the time from each to the next."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True)
class Gaps:
    """Time between two setpoints that follow each other, ms."""

    p50_ms: float
    p99_ms: float
    max_ms: float


class GapMeter:
    """Collects until `take`; `pause` between two streams, so that the time without setpoints is no gap."""

    def __init__(self) -> None:
        self._last_s: float | None = None
        self._gaps_s: list[float] = []

    def note(self, sent_s: float) -> None:
        """One setpoint was sent."""
        if self._last_s is not None:
            self._gaps_s.append(sent_s - self._last_s)
        self._last_s = sent_s

    def pause(self) -> None:
        """No setpoint is due now."""
        self._last_s = None

    def take(self) -> Gaps | None:
        """Of what was collected since the last call; None where there was no gap to measure."""
        if not self._gaps_s:
            return None
        gaps_ms = np.array(self._gaps_s) * 1e3
        self._gaps_s.clear()
        middle, high = np.percentile(gaps_ms, (50, 99))
        return Gaps(float(middle), float(high), float(gaps_ms.max()))

"""Rate, computing time and latency of a run, of bounded size however long it runs."""

from __future__ import annotations

import math
from collections import Counter, deque

import numpy as np

from perception.sources.api import SourceHealth
from perception.view.shot import Timing

_RECENT = 300
_RATE_FRAMES = 30
_KEPT = 100_000
_EVENTS_KEPT = 100


class RunStatistics:
    """Timings of the newest frames for the health line, of the whole run (the newest 100 000 frames) for the summary."""

    def __init__(self) -> None:
        self.frames = 0
        self._capture_s: deque[float] = deque(maxlen=_RATE_FRAMES)
        self._process_s: deque[float] = deque(maxlen=_KEPT)
        self._latency_s: deque[float] = deque(maxlen=_KEPT)
        self._events: Counter[str] = Counter()

    def add(self, capture_s: float, process_s: float, latency_s: float | None, events: tuple[str, ...]) -> Timing:
        self.frames += 1
        if self._capture_s and capture_s < self._capture_s[-1]:
            self._capture_s.clear()
        self._capture_s.append(capture_s)
        self._process_s.append(process_s)
        for event in events:
            if event in self._events or len(self._events) < _EVENTS_KEPT:
                self._events[event] += 1
        process = _percentiles(self._process_s)
        if latency_s is None:
            return Timing(self._rate_hz(), process_s, *process)
        self._latency_s.append(latency_s)
        return Timing(self._rate_hz(), process_s, *process, latency_s, *_percentiles(self._latency_s))

    def summary(self, elapsed_s: float, health: SourceHealth) -> str:
        """One line for the end of a run, and one for every kind of event."""
        if not self.frames:
            return "no frame came"
        rate_hz = self.frames / elapsed_s if elapsed_s > 0 else math.nan
        p50, p99 = np.percentile(self._process_s, (50, 99)) * 1e3
        parts = [f"{self.frames} {'frame' if self.frames == 1 else 'frames'} in {elapsed_s:.1f} s, {rate_hz:.1f} a second"]
        parts.append(f"computing p50 {p50:.2f} ms, p99 {p99:.2f} ms")
        if self._latency_s:
            p50, p99 = np.percentile(self._latency_s, (50, 99)) * 1e3
            parts.append(f"latency p50 {p50:.1f} ms, p99 {p99:.1f} ms")
        parts.append(f"lost {health.lost}, skipped {health.skipped}, restarts {health.restarts}")
        count = self._events.total()
        parts.append(f"{count or 'no'} {'event' if count == 1 else 'events'}")
        return "\n".join(["; ".join(parts), *(f"  {times} x {event}" for event, times in self._events.most_common())])

    def _rate_hz(self) -> float:
        span_s = self._capture_s[-1] - self._capture_s[0]
        return (len(self._capture_s) - 1) / span_s if span_s > 0 else math.nan


def _percentiles(times_s: deque[float]) -> tuple[float, float]:
    """50th and 99th percentile of the newest."""
    newest = sorted(times_s[i] for i in range(max(-_RECENT, -len(times_s)), 0))
    return newest[len(newest) // 2], newest[min(len(newest) - 1, math.ceil(0.99 * len(newest)) - 1)]

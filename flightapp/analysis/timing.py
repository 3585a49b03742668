"""Figures of timing: latencies, setpoint rate and gaps, load of the process."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from flightapp.core.types import Array
from flightapp.recording.phases import Window
from flightapp.recording.reader import Recording, Series
from flightapp.recording.series import no_messages

Spread = dict[str, float | None]
STAGES = ("coarse", "fine")


def spread(values: Array, names: tuple[str, ...] = ("p50", "p99")) -> Spread:
    """Percentiles of the finite values, null without any."""
    finite = values[np.isfinite(values)]
    if len(finite) == 0:
        return dict.fromkeys(names)
    return {name: float(np.percentile(finite, float(name[1:]))) for name in names}


def mean_and_max(values: Array) -> Spread:
    """Mean and maximum of the finite values, null without any."""
    finite = values[np.isfinite(values)]
    if len(finite) == 0:
        return {"mean": None, "max": None}
    return {"mean": float(finite.mean()), "max": float(finite.max())}


def within(series: Series, window: Window | None) -> Series:
    """The messages from the start of `window` until before its end; none without one."""
    if window is None:
        return no_messages(series.topic)
    return series.chosen((series.t_s >= window.start_s) & (series.t_s < window.end_s))


def decision_latency_ms(decisions: Series) -> dict[str, Array]:
    """Durations of the planner's steps by stage: `diagnostics["stage"]`, or the mode where it is named for one."""
    latency = decisions.column("latency_s") * 1e3
    stages = [
        _stage(told, mode) for told, mode in zip(decisions.texts("diagnostics.stage"), decisions.texts("mode"), strict=True)
    ]
    return {stage: latency[np.array([stage == other for other in stages], dtype=bool)] for stage in STAGES}


def frame_to_setpoint_ms(setpoints: Series) -> Array:
    """From the capture of a depth frame to the first setpoint that rests on it, one value a frame."""
    new = setpoints.column("new_frame") == 1.0
    latency = (setpoints.column("t_s") - setpoints.column("frame_t_s"))[new] * 1e3
    return np.asarray(latency[np.isfinite(latency)])


def perception_latency_ms(obstacles: Series) -> Array:
    """Processing time of each depth frame."""
    return obstacles.column("perception_latency_s") * 1e3


def setpoint_rate_hz(setpoints: Series) -> float | None:
    """Mean rate; null with fewer than two setpoints."""
    times = _times(setpoints)
    return (len(times) - 1) / float(times[-1] - times[0]) if len(times) >= 2 and times[-1] > times[0] else None


def setpoint_gap_ms(setpoints: Series) -> Spread:
    """Time between two setpoints that follow each other: median, 99th percentile and the longest."""
    return spread(np.diff(_times(setpoints)) * 1e3, ("p50", "p99", "p100"))


def dropped(recording: Recording) -> int | None:
    """Messages that were logged and are not in the file; null where an incomplete file cannot tell."""
    told = recording.topic("/health").column("recording_dropped")
    known = [int(told[np.isfinite(told)].max())] if np.isfinite(told).any() else []
    if recording.complete:
        known.append(int(recording.metadata.get("recording", {}).get("dropped", "0")))
    return max(known, default=None)


def share(names: Iterable[str]) -> dict[str, float]:
    """Fraction of each name among all."""
    listed = list(names)
    return {name: listed.count(name) / len(listed) for name in sorted(set(listed))}


def _times(series: Series) -> Array:
    times = series.column("t_s")
    return np.sort(times[np.isfinite(times)])


def _stage(told: str, mode: str) -> str | None:
    return told or next((stage for stage in STAGES if stage in mode.lower()), None)

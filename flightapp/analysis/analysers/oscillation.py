"""Oscillation: setpoints that swing to and fro, and a planner that cannot decide between modes."""

from __future__ import annotations

import numpy as np

from flightapp.analysis.analysers.analyser import PROFILE, Analyser
from flightapp.analysis.analysers.subject import Subject
from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.ulog.spans import Span
from flightapp.core.types import Array

NAME = "oscillation"
WINDOW_S = 3.0
REVERSALS = 7
"""In WINDOW_S: more than one full swing a second. Slower ones are manoeuvres round obstacles and the evader."""
SWING_SHARE = 0.2
"""Of the top speed: a smaller swing is not to be seen in flight."""
MODE_WINDOW_S = 5.0
MODE_CHANGES = 6
"""In MODE_WINDOW_S: three times there and back."""


def examine(subject: Subject) -> list[Finding]:
    return [*_swings(subject), *_flapping(subject)] or [
        Finding(NAME, Severity.OK, "steady", "Neither setpoints nor modes swing to and fro.", vehicle=subject.name)
    ]


def _swings(subject: Subject) -> list[Finding]:
    swing_m_s = SWING_SHARE * subject.profile.limits.speed_max_m_s
    for span in subject.offboard:
        setpoints = subject.during("/setpoint", span)
        velocity = setpoints.vectors("velocity_ned_m_s")
        for axis, name in enumerate(("north", "east")):
            times = setpoints.t_s[reversals(velocity[:, axis], swing_m_s)]
            crowd = crowded(times, WINDOW_S, REVERSALS)
            if crowd is not None:
                most = float(most_within(times, WINDOW_S))
                text = f"The setpoint to {name} reversed {most:.0f} times within {WINDOW_S:g} s by {swing_m_s:g} m/s and more."
                evidence: dict[str, float | str] = {"reversals": most, "window_s": WINDOW_S, "swing_m_s": swing_m_s, "axis": name}
                return [
                    Finding(NAME, Severity.WARNING, "setpoint swings", text, crowd.from_s, crowd.to_s, evidence, subject.name)
                ]
    return []


def _flapping(subject: Subject) -> list[Finding]:
    decisions = subject.topic("/decision")
    modes = decisions.texts("mode")
    changes = [index for index in range(1, len(modes)) if modes[index] != modes[index - 1]]
    times = decisions.t_s[changes]
    crowd = crowded(times, MODE_WINDOW_S, MODE_CHANGES)
    if crowd is None:
        return []
    most = float(most_within(times, MODE_WINDOW_S))
    involved = ", ".join(sorted({modes[index] for index in changes if crowd.from_s <= decisions.t_s[index] <= crowd.to_s}))
    text = f"The planner changed its mode {most:.0f} times within {MODE_WINDOW_S:g} s ({involved})."
    evidence: dict[str, float | str] = {"changes": most, "window_s": MODE_WINDOW_S, "modes": involved}
    return [Finding(NAME, Severity.WARNING, "mode flaps", text, crowd.from_s, crowd.to_s, evidence, subject.name)]


def reversals(values: Array, swing: float) -> list[int]:
    """Where a signal (n,) turns round after having moved by `swing` and more: its turning points, smaller wiggles left out."""
    found: list[int] = []
    low = high = 0
    direction = 0
    signal = values.tolist()
    for index, value in enumerate(signal):
        low = index if value < signal[low] else low
        high = index if value > signal[high] else high
        if direction <= 0 and value - signal[low] >= swing:
            found += [low] if direction < 0 else []
            direction, high = 1, index
        elif direction >= 0 and signal[high] - value >= swing:
            found += [high] if direction > 0 else []
            direction, low = -1, index
    return found


def most_within(times: Array, window_s: float) -> int:
    """The greatest number of `times` (n,), in order, within any `window_s`."""
    return int((np.searchsorted(times, times + window_s, side="right") - np.arange(len(times))).max(initial=0))


def crowded(times: Array, window_s: float, count: int) -> Span | None:
    """From the first to the last of all windows of `window_s` that hold `count` of `times` or more."""
    starts = np.flatnonzero(np.searchsorted(times, times + window_s, side="right") - np.arange(len(times)) >= count)
    if len(starts) == 0:
        return None
    last = int(np.searchsorted(times, times[starts[-1]] + window_s, side="right")) - 1
    return Span(float(times[starts[0]]), float(times[last]))


ANALYSER = Analyser(NAME, "Were the setpoints and modes steady?", ("/setpoint", "/decision", "/autopilot", PROFILE), examine)

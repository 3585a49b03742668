"""Does a recording hold what the channel table promises? Rates while airborne, channel by channel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flightapp.config.mission import Vehicle
from flightapp.recording.channels import CHANNELS, Channel
from flightapp.recording.phases import AIRBORNE, Window, phases_of
from flightapp.recording.reader import Recording

SHARE_MIN = 0.8
PURSUIT_TOPICS = ("/target", "/decision", "/setpoint")
"""Promised only while the planner flies."""


@dataclass(frozen=True, slots=True)
class RateFinding:
    """One channel: promised and measured rate over `window_s` seconds of flight."""

    topic: str
    expected_hz: float
    measured_hz: float
    window_s: float

    @property
    def good(self) -> bool:
        return self.measured_hz >= SHARE_MIN * self.expected_hz

    def __str__(self) -> str:
        return f"{self.topic}: {self.measured_hz:.1f} Hz of {self.expected_hz:g} Hz over {self.window_s:.1f} s"


def check_rates(
    recording: Recording, vehicle: Vehicle | None = None, channels: tuple[Channel, ...] = CHANNELS
) -> tuple[RateFinding, ...]:
    """The rate of every channel that promises one; empty if the vehicle never flew.

    vehicle: leaves out what it cannot have: obstacles without a camera, a target of the evader's own.
    """
    phases = phases_of(recording)
    absent = () if vehicle is None else _absent(vehicle)
    findings = []
    for channel in channels:
        window = phases.window(("pursue",) if channel.topic in PURSUIT_TOPICS else AIRBORNE)
        if channel.logged and channel.rate_hz > 0.0 and channel.topic not in absent and window is not None:
            findings.append(_finding(recording, channel, window))
    return tuple(findings)


def _finding(recording: Recording, channel: Channel, window: Window) -> RateFinding:
    times = recording.topic(channel.topic).t_s
    count = int(np.count_nonzero((times >= window.start_s) & (times < window.end_s)))
    return RateFinding(channel.topic, channel.rate_hz, count / window.length_s, window.length_s)


def _absent(vehicle: Vehicle) -> tuple[str, ...]:
    return (*(() if vehicle.camera else ("/obstacles",)), *(("/target",) if vehicle.role == "evader" else ()))

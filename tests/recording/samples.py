"""Messages to record in tests."""

from __future__ import annotations

import math

from flightapp.recording import messages
from flightapp.recording.recorder import Recorder

T0_S = 1_750_000_000.0


def own(t_s: float, north_m: float = 0.0) -> messages.OwnState:
    return messages.OwnState(t_s, [north_m, 1.0, -5.0], [1.0, 0.0, 0.0], 0.0, 0.0, 0.3, 0.01)


def obstacles(t_s: float) -> messages.Obstacles:
    discs = [[10.0, 2.0, 0.5, 0.0, 0.0, -math.inf, math.inf], [12.0, 2.0, 0.5, 0.0, 0.0, -9.0, 0.0]]
    return messages.Obstacles(t_s, t_s - 0.03, 1, discs, [[0.5, 1.0]], 0.004, 0, [])


def target(t_s: float) -> messages.Target:
    return messages.Target(t_s, [20.0, 0.0, -5.0], [0.0, 0.0, 0.0], 0.2, 0.05)


def event(t_s: float, level: str = "warning") -> messages.Event:
    return messages.Event(t_s, level, "link-stale", "nothing heard from p2", {"age_s": 0.7})


def log_steps(recorder: Recorder, count: int, rate_hz: float = 25.0) -> None:
    """`count` steps of a flight."""
    for step in range(count):
        t_s = T0_S + step / rate_hz
        recorder.log("/own", own(t_s, float(step)), t_s)
        recorder.log("/obstacles", obstacles(t_s), t_s)
        recorder.log("/target", target(t_s), t_s)

"""What happened, in order: modes, arming, take-off and landing, failsafe flags, and what PX4 said."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flightapp.analysis.ulog.log import FlightLog, Topic
from flightapp.analysis.ulog.modes import mode_name

_LEVELS = ("error", "error", "error", "error", "warning", "info", "info", "info")
"""By syslog level, in the words of our own events."""


@dataclass(frozen=True, slots=True)
class Entry:
    """One event; `level` is info, warning or error, as of our own events."""

    t_s: float
    level: str
    name: str
    text: str


def timeline_of(log: FlightLog) -> list[Entry]:
    """All entries in the order of their times (s since the log began)."""
    entries = [Entry(m.t_s, _LEVELS[min(max(m.level, 0), 7)], "message", m.text) for m in log.messages]
    status, landed = log.topic("vehicle_status"), log.topic("vehicle_land_detected")
    entries += [Entry(t_s, "info", "mode", mode_name(value)) for t_s, value in _changes(status, "nav_state")]
    entries += [Entry(t_s, "info", "motors", "armed" if v == 2 else "disarmed") for t_s, v in _changes(status, "arming_state")]
    entries += [Entry(t_s, "info", "ground", "landed" if value else "in the air") for t_s, value in _changes(landed, "landed")]
    acted = _changes(status, "failsafe")
    acted = acted if acted and acted[0][1] else acted[1:]
    entries += [Entry(t_s, "error" if value else "info", "failsafe", "acts" if value else "over") for t_s, value in acted]
    entries += _flags(log.topic("failsafe_flags"))
    return sorted(entries, key=lambda entry: entry.t_s)


def _flags(flags: Topic | None) -> list[Entry]:
    """Flags that change; what holds from the beginning is no event. `mode_req_*` are constants of the modes."""
    if flags is None:
        return []
    found = []
    for name in flags.fields:
        if not name.startswith(("mode_req_", "timestamp")):
            for t_s, value in _changes(flags, name)[1:]:
                found.append(
                    Entry(t_s, "warning" if value else "info", "failsafe flag", f"{name} {'set' if value else 'cleared'}")
                )
    return found


def _changes(topic: Topic | None, column: str) -> list[tuple[float, int]]:
    """(time, value) of the first sample and of every one that differs from the one before."""
    values = None if topic is None else topic.column(column)
    if topic is None or values is None or not len(values):
        return []
    first = np.concatenate(([0], np.flatnonzero(np.diff(values)) + 1))
    return [(float(topic.t_s[index]), int(values[index])) for index in first]

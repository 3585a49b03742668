"""One PX4 log, examined: findings, verdict, summary and time line."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flightapp.analysis.findings import Finding, Severity, as_json, worst
from flightapp.analysis.ulog.analyser import run_analyser, topics_needed
from flightapp.analysis.ulog.analysers import ANALYSERS
from flightapp.analysis.ulog.gps_time import gps_offset_s
from flightapp.analysis.ulog.log import FlightLog, load_log
from flightapp.analysis.ulog.modes import mode_name
from flightapp.analysis.ulog.spans import total_s
from flightapp.analysis.ulog.timeline import Entry, timeline_of

_MORE = ("vehicle_gps_position", "sensor_gps", "offboard_control_mode", "system_power", "trajectory_setpoint")
_HEADLINES = {
    Severity.OK: "Nothing to complain of in the autopilot's log",
    Severity.NOTE: "No fault in the autopilot's log; read the notes",
    Severity.WARNING: "The autopilot's log has warnings",
    Severity.FAILURE: "Something failed, as the autopilot's log shows",
}


@dataclass(frozen=True, slots=True)
class ExaminedLog:
    """Times of findings and entries in s since the log began."""

    log: FlightLog
    findings: tuple[Finding, ...]
    entries: tuple[Entry, ...]

    @property
    def worst(self) -> Severity:
        return worst(self.findings)

    @property
    def headline(self) -> str:
        return _HEADLINES[self.worst]


def examine(path: Path) -> ExaminedLog:
    """Read a log and run every analyser over it; InputError if it cannot be read."""
    log = load_log(path, sorted({*topics_needed(ANALYSERS), *_MORE}))
    findings = tuple(finding for analyser in ANALYSERS for finding in run_analyser(analyser, log))
    return ExaminedLog(log, findings, tuple(timeline_of(log)))


def summary_of(examined: ExaminedLog) -> dict[str, Any]:
    """For summary.json; null: not known."""
    log = examined.log
    gps_s = gps_offset_s(log)
    return {
        "file": log.path.name,
        "verdict": examined.worst.name.lower(),
        "headline": examined.headline,
        "findings": [as_json(finding) for finding in examined.findings],
        "length_s": log.end_s,
        "airborne_s": total_s(log.airborne()),
        "began_unix_s": gps_s,
        "autopilot": {"hardware": log.information.get("ver_hw"), "software": software_of(log)},
        "modes": _modes(log),
        "events": [{"t_s": one.t_s, "level": one.level, "name": one.name, "text": one.text} for one in examined.entries],
    }


def software_of(log: FlightLog) -> str | None:
    """Release of PX4 as text, 1.16.0; None where it is not in the log. The number is 0xMMmmppTT."""
    release = log.information.get("ver_sw_release", "")
    if not release.isdigit():
        return None
    number = int(release)
    return f"PX4 {number >> 24 & 0xFF}.{number >> 16 & 0xFF}.{number >> 8 & 0xFF}"


def _modes(log: FlightLog) -> list[str]:
    """In the order flown, while armed."""
    status = log.topic("vehicle_status")
    states = None if status is None else status.column("nav_state")
    arming = None if status is None else status.column("arming_state")
    if states is None or arming is None:
        return []
    names = [mode_name(int(state)) for state in states[arming == 2]]
    return [name for index, name in enumerate(names) if index == 0 or names[index - 1] != name]

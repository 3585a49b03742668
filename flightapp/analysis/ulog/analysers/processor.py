"""Load of the autopilot's processor."""

from __future__ import annotations

from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.ulog.analyser import Analyser, not_known
from flightapp.analysis.ulog.log import FlightLog
from flightapp.analysis.ulog.spans import spans_of, total_s

NAME = "processor"
LOAD_MAX = 0.9
"""PX4 warns from here on (COM_CPU_MAX)."""
LASTING_S = 2.0


def examine(log: FlightLog) -> list[Finding]:
    topic = log.topic("cpuload")
    load = None if topic is None else topic.column("load")
    if topic is None or load is None:
        return [not_known(NAME, "the load was not logged")]
    busy = spans_of(topic.t_s, load > LOAD_MAX, least_s=LASTING_S)
    if not busy:
        return [Finding(NAME, Severity.OK, "load low", f"{load.max():.0%} at most.", evidence={"load_max": float(load.max())})]
    text = f"Above {LOAD_MAX:.0%} for {total_s(busy):.1f} s, {load.max():.0%} at most."
    return [Finding(NAME, Severity.WARNING, "processor overloaded", text, busy[0].from_s, busy[-1].to_s)]


ANALYSER = Analyser(NAME, ("cpuload",), examine)

"""What PX4 itself complained of, in its own words."""

from __future__ import annotations

from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.ulog.analyser import Analyser
from flightapp.analysis.ulog.log import FlightLog, Message

NAME = "messages"
CRITICAL, ERROR, WARNING = 2, 3, 4
"""Syslog levels."""
QUOTED_MAX = 5


def examine(log: FlightLog) -> list[Finding]:
    flown = log.airborne()
    complaints = [message for message in log.messages if message.level <= WARNING]
    aloft = [message for message in complaints if any(span.from_s <= message.t_s <= span.to_s for span in flown)]
    grounded = [message for message in complaints if message not in aloft]
    found = []
    if aloft:
        worst = min(message.level for message in aloft)
        severity = Severity.FAILURE if worst <= ERROR else Severity.WARNING
        found.append(_finding(severity, "PX4 complained in flight", aloft))
    if grounded:
        found.append(_finding(Severity.NOTE, "PX4 complained on the ground", grounded))
    return found


def _finding(severity: Severity, title: str, messages: list[Message]) -> Finding:
    texts = list(dict.fromkeys(message.text for message in messages))
    more = "" if len(texts) <= QUOTED_MAX else f" (and {len(texts) - QUOTED_MAX} more)"
    quoted = "; ".join(texts[:QUOTED_MAX])
    evidence = {"messages": float(len(messages))}
    return Finding(NAME, severity, title, f"{quoted}{more}.", messages[0].t_s, messages[-1].t_s, evidence)


ANALYSER = Analyser(NAME, ("vehicle_status",), examine)

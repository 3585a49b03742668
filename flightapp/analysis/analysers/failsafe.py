"""Failsafe: what the vehicle's own failsafes did, and why."""

from __future__ import annotations

from collections.abc import Iterator

from flightapp.analysis.analysers.analyser import Analyser
from flightapp.analysis.analysers.subject import Subject
from flightapp.analysis.findings import Finding, Severity
from flightapp.safety.failsafe.table import PERSONS, Condition, State

NAME = "failsafe"


def examine(subject: Subject) -> list[Finding]:
    return list(_entered(subject)) or [Finding(NAME, Severity.OK, "none acted", "No failsafe acted.", vehicle=subject.name)]


def _entered(subject: Subject) -> Iterator[Finding]:
    """A state that ends the mission is a failure, unless a person wanted it; the milder ones are warnings."""
    events = subject.topic("/event")
    for index, name in enumerate(events.texts("name")):
        data = events.values("data")[index]
        if name != "failsafe" or not isinstance(data, dict) or data.get("state") in (None, State.NORMAL.name):
            continue
        state, condition = str(data["state"]), str(data.get("condition", ""))
        severity = Severity.FAILURE if State[state] > State.HOLD else Severity.WARNING
        severity = Severity.NOTE if condition in _PERSONS else severity
        t_s = float(events.t_s[index])
        title = f"{state.lower()}: {condition.replace('_', ' ')}"
        evidence: dict[str, float | str] = {"state": state, "condition": condition}
        yield Finding(NAME, severity, title, events.texts("text")[index], t_s, t_s, evidence, subject.name)


_PERSONS: frozenset[str] = frozenset(Condition(one).value for one in PERSONS)

ANALYSER = Analyser(NAME, "What did its own failsafes do?", ("/phase",), examine)

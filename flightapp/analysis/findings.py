"""What an analyser found: one type for every analyser, of our recordings and of the autopilot's logs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any


class Severity(IntEnum):
    """How bad; the worst of a flight is its verdict."""

    OK = 0
    """Looked at, nothing to complain of."""
    NOTE = 1
    """Worth knowing: something could not be looked at, or was unusual but within its limits."""
    WARNING = 2
    """A margin was used up: look at it before the next flight."""
    FAILURE = 3
    """A limit was broken, or something stopped working in flight."""


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing found, with the numbers that it rests on.

    `analyser` names its source, `title` is a headline of a few words, `text` one or two sentences. `from_s` and `to_s` are on the
    time line of the page that shows it, both None where it belongs to no stretch of time. `evidence`: name with unit to value.
    """

    analyser: str
    severity: Severity
    title: str
    text: str
    from_s: float | None = None
    to_s: float | None = None
    evidence: Mapping[str, float | str] = field(default_factory=dict)
    vehicle: str = ""
    """Whose; empty where it is the whole run's or the log's own."""


def worst(findings: tuple[Finding, ...] | list[Finding]) -> Severity:
    """The worst severity of all; OK where there is nothing."""
    return max((finding.severity for finding in findings), default=Severity.OK)


def reaches(summary: Mapping[str, Any], least: str | None) -> bool:
    """Whether a summary, ours or of an autopilot's log, holds a finding as bad as `least`, in the logs beside it too."""
    if least is None:
        return False
    told = [*summary["findings"], *(one for log in summary.get("autopilot_logs", ()) for one in log.get("findings", ()))]
    return any(Severity[one["severity"].upper()] >= Severity[least.upper()] for one in told)


def as_json(finding: Finding) -> dict[str, object]:
    """For summary.json: plain values, the severity by its name in small letters."""
    return {
        "analyser": finding.analyser,
        "vehicle": finding.vehicle,
        "severity": finding.severity.name.lower(),
        "title": finding.title,
        "text": finding.text,
        "from_s": finding.from_s,
        "to_s": finding.to_s,
        "evidence": dict(finding.evidence),
    }


def of_json(told: Mapping[str, Any]) -> Finding:
    """The finding of an entry of summary.json."""
    return Finding(
        told["analyser"],
        Severity[told["severity"].upper()],
        told["title"],
        told["text"],
        told["from_s"],
        told["to_s"],
        told["evidence"],
        told["vehicle"],
    )

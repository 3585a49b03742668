"""What an analyser of our recordings is, and how all of them are run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from flightapp.analysis.analysers.subject import Subject
from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.run import Run

PROFILE, MISSION = "profile", "mission"
"""May stand among the needs: the file must have been kept, beside the recordings or in them."""


def always(_: Subject) -> bool:
    """For an analyser that concerns every vehicle."""
    return True


@dataclass(frozen=True, slots=True)
class Analyser:
    """`examine` looks at one vehicle that flew. `needs`: what it cannot do without, topics and kept files.

    `concerns`: whether the question makes sense for the vehicle at all; `question` stands in the report.
    """

    name: str
    question: str
    needs: tuple[str, ...]
    examine: Callable[[Subject], list[Finding]]
    concerns: Callable[[Subject], bool] = always


def examine_run(run: Run, analysers: Sequence[Analyser]) -> tuple[Finding, ...]:
    """What every analyser finds on every vehicle, at least one finding each: silence would look like health."""
    found: list[Finding] = []
    for vehicle in run.vehicles:
        subject = Subject(run, vehicle)
        if subject.airborne is None:
            text = "Its recording has no flight: nothing was looked at."
            found.append(Finding("flight", Severity.NOTE, "did not fly", text, evidence={"known": "no"}, vehicle=vehicle.name))
            continue
        for analyser in analysers:
            if analyser.concerns(subject):
                found += _examined(analyser, subject)
    return tuple(found)


def _examined(analyser: Analyser, subject: Subject) -> list[Finding]:
    missing = [need for need in analyser.needs if not _has(subject, need)]
    if missing:
        return [
            not_known(analyser.name, subject, f"{' and '.join(missing)} {'was' if len(missing) == 1 else 'were'} not recorded")
        ]
    try:
        return analyser.examine(subject)
    except (KeyError, TypeError, ValueError) as error:  # a recording by another version: one question less, not no report
        return [not_known(analyser.name, subject, f"the recording is not as expected ({type(error).__name__}: {error})")]


def _has(subject: Subject, need: str) -> bool:
    if need == PROFILE:
        return subject.vehicle.profile is not None
    if need == MISSION:
        return subject.run.mission is not None
    return len(subject.topic(need)) > 0


def not_known(analyser: str, subject: Subject, why: str) -> Finding:
    """For what the recording cannot tell."""
    text = f"Nothing can be said of this: {why}."
    return Finding(analyser, Severity.NOTE, "not known", text, evidence={"known": "no"}, vehicle=subject.name)

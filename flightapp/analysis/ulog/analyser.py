"""What an analyser of PX4 logs is, and how all of them are run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.ulog.log import FlightLog


@dataclass(frozen=True, slots=True)
class Analyser:
    """`needs`: topics without which nothing can be said; of names joined by `|` one is enough."""

    name: str
    needs: tuple[str, ...]
    examine: Callable[[FlightLog], list[Finding]]


def run_analyser(analyser: Analyser, log: FlightLog) -> list[Finding]:
    """Its findings, at least one: silence would look like health."""
    missing = [need for need in analyser.needs if not any(name in log.topics for name in need.split("|"))]
    if missing:
        names = " and ".join(need.replace("|", " or ") for need in missing)
        return [not_known(analyser.name, f"{names} was not logged")]
    try:
        found = analyser.examine(log)
    except Exception as error:  # damaged values may break any of them; the others must still speak
        return [not_known(analyser.name, f"its data are damaged ({type(error).__name__})")]
    return found or [Finding(analyser.name, Severity.OK, "nothing found", "Looked at; nothing to complain of.")]


def not_known(analyser: str, why: str) -> Finding:
    """For what the log cannot tell."""
    return Finding(analyser, Severity.NOTE, "not known", f"Nothing can be said of this: {why}.", evidence={"known": "no"})


def topics_needed(analysers: Sequence[Analyser]) -> tuple[str, ...]:
    """All topics that any of them needs."""
    return tuple(sorted({name for analyser in analysers for need in analyser.needs for name in need.split("|")}))

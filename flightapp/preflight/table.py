"""The checklist for a person and for machines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

from rich.console import Console
from rich.table import Table

from flightapp.preflight.px4_parameters import Finding
from flightapp.preflight.result import Level, Result, is_ready
from flightapp.preflight.session import Written

COLOURS = {
    Level.PASSED: "green",
    Level.NOTED: "cyan",
    Level.SKIPPED: "dim",
    Level.WAIVED: "magenta",
    Level.WARNING: "yellow",
    Level.RUNNING: "blue",
    Level.FAILED: "bold red",
}


def print_checklist(results: Sequence[Result], vehicle: str) -> None:
    """One row a check; the remedy stands under what needs one."""
    table = Table(title=f"Preflight of {vehicle}", show_lines=False)
    for heading in ("check", "result", "found", "because"):
        table.add_column(heading, overflow="fold")
    for result in results:
        remedy = (
            "" if result.level in (Level.PASSED, Level.NOTED, Level.SKIPPED) or not result.remedy else f"\n-> {result.remedy}"
        )
        colour = COLOURS[result.level]
        table.add_row(result.check, f"[{colour}]{result.level.word}[/]", result.found + remedy, result.reason)
    console = Console(width=None if Console().is_terminal else 150)
    console.print(table)
    console.print(summary(results), highlight=False)


def summary(results: Sequence[Result]) -> str:
    """One line: ready or not, and for want of what."""
    counts = {level: sum(result.level is level for result in results) for level in Level}
    text = ", ".join(f"{count} {level.word}" for level, count in counts.items() if count)
    if is_ready(list(results)):
        return f"READY TO FLY: {text}."
    wanting = ", ".join(result.check for result in results if result.level >= Level.RUNNING)
    return f"NOT READY: {text}. Wanting: {wanting}."


def as_json(results: Sequence[Result], written: Sequence[Written], vehicle: str) -> dict[str, object]:
    """The same for machines."""
    rows = [
        {"check": one.check, "level": one.level.word, "found": one.found, "reason": one.reason, "remedy": one.remedy}
        for one in results
    ]
    return {
        "vehicle": vehicle,
        "ready": is_ready(list(results)),
        "results": rows,
        "parameters": [asdict(one) for one in written],
    }


def print_parameters(wrong: Sequence[Finding]) -> None:
    """Old and new values side by side, before anything is written."""
    table = Table(title="Parameters to write")
    for heading in ("parameter", "now", "new", "because"):
        table.add_column(heading, overflow="fold")
    for finding in wrong:
        now = "not answered" if finding.value is None else f"{finding.value:g}"
        table.add_row(finding.needed.name, now, f"{finding.needed.write:g}", finding.needed.reason)
    Console(width=None if Console().is_terminal else 150).print(table)


def written_lines(written: Sequence[Written]) -> list[str]:
    """One line a parameter: what stands in the autopilot now."""
    lines = []
    for one in written:
        now = "not written" if one.read_back is None else f"now {one.read_back:g}"
        lines.append(f"{one.name}: was {one.old if one.old is None else f'{one.old:g}'}, {now}")
    return lines

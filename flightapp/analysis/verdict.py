"""One line that says how the run went."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from flightapp.analysis.findings import Severity


@dataclass(frozen=True, slots=True)
class Verdict:
    """good: captured and nothing to complain of; attention: read on; bad: a limit was broken or something failed."""

    level: Literal["good", "attention", "bad"]
    headline: str
    reasons: tuple[str, ...]


def verdict_of(summary: dict[str, Any]) -> Verdict:
    """The verdict on one summary; every reason is one clause."""
    broken = _broken(summary)
    remarks = _remarks(summary)
    outcome = summary["outcome"]
    bad = bool(broken) or outcome == "fault"
    level: Literal["good", "attention", "bad"] = "bad" if bad else "attention" if remarks or outcome != "captured" else "good"
    return Verdict(level, _headline(summary), (*broken, *remarks))


def one_line(summary: dict[str, Any]) -> str:
    """The headline and how much was found, for a terminal."""
    count = {severity: len(_found(summary, severity)) for severity in (Severity.FAILURE, Severity.WARNING)}
    told = [f"{number} {severity.name.lower()}{'s' * (number != 1)}" for severity, number in count.items() if number]
    return f"{_headline(summary)}; {', '.join(told) or 'no failures or warnings'}"


def _headline(summary: dict[str, Any]) -> str:
    outcome, time_s = summary["outcome"], summary["capture_time_s"]
    if outcome == "captured":
        return "The evader was captured" + ("" if time_s is None else f" after {time_s:.1f} s")
    return {
        "escaped": "The evader escaped across the boundary",
        "timeout": "The time limit passed without a capture",
        "aborted": "The mission was aborted",
        "fault": "The mission ended with a fault",
    }.get(outcome or "", "No outcome was recorded")


def _broken(summary: dict[str, Any]) -> list[str]:
    return _found(summary, Severity.FAILURE)


def _remarks(summary: dict[str, Any]) -> list[str]:
    found = _found(summary, Severity.WARNING)
    found += [f"{error['vehicle']}: {error['text']}" for error in summary["errors"]]
    clearance, wanted = summary["min_obstacle_clearance_m"], summary["clearance_wanted_m"]
    if clearance is not None and wanted is not None and 0.0 <= clearance < wanted:
        found.append(f"the clearance to an obstacle fell to {clearance:.2f} m, below the safety margin of {wanted:.2f} m")
    cut = [recording["file"] for recording in summary["recordings"] if not recording["complete"]]
    if cut:
        found.append(f"incomplete recordings: {', '.join(cut)}")
    if summary["dropped"]:
        found.append(f"{summary['dropped']} messages were not recorded")
    return found


def _found(summary: dict[str, Any], severity: Severity) -> list[str]:
    """What the analysers found of this severity, one clause each."""
    chosen = [finding for finding in summary["findings"] if finding["severity"] == severity.name.lower()]
    return [f"{finding['vehicle']}: {finding['title']}" if finding["vehicle"] else finding["title"] for finding in chosen]

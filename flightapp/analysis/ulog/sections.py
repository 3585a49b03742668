"""The HTML of one PX4 log's part of a page. Every logged text is escaped."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.ulog.flight import ExaminedLog
from flightapp.analysis.ulog.timeline import Entry

_LEVELS = {Severity.OK: "good", Severity.NOTE: "good", Severity.WARNING: "attention", Severity.FAILURE: "bad"}
_BADGES = {Severity.OK: "phase", Severity.NOTE: "", Severity.WARNING: "warning", Severity.FAILURE: "error"}


def verdict_box(examined: ExaminedLog) -> str:
    """The box at the top: headline and what is wrong."""
    wrong = sorted((one for one in examined.findings if one.severity >= Severity.WARNING), key=lambda one: -one.severity)
    items = "".join(f"<li><strong>{escape(one.title)}</strong>: {escape(one.text)}</li>" for one in wrong)
    below = f"<ul>{items}</ul>" if items else ""
    return f'<div class="verdict {_LEVELS[examined.worst]}"><strong>{escape(examined.headline)}.</strong>{below}</div>'


def findings_table(findings: Sequence[Finding]) -> str:
    """The worst first; within one severity in the order of the analysers."""
    ordered = sorted(findings, key=lambda finding: -finding.severity)
    rows = "".join(
        f'<tr><td><span class="badge {_BADGES[one.severity]}">{one.severity.name.lower()}</span></td>'
        f"<td>{escape(one.analyser)}</td><td><strong>{escape(one.title)}</strong><br>{escape(one.text)}</td>"
        f"<td>{_span(one)}</td><td>{escape(_evidence(one))}</td></tr>"
        for one in ordered
    )
    head = "<tr><th></th><th>Analyser</th><th>Finding</th><th>From – to, s</th><th>Evidence</th></tr>"
    return f'<div class="scroll"><table class="findings"><thead>{head}</thead><tbody>{rows}</tbody></table></div>'


def entries_table(entries: Sequence[Entry]) -> str:
    """The autopilot's own time line; its times are the page's."""
    rows = "".join(
        f"<tr><td>{round(entry.t_s, 2) + 0.0:.2f}</td>"
        f'<td><span class="badge {escape(entry.level)}">{escape(entry.name)}</span></td>'
        f"<td>{escape(entry.text)}</td></tr>"
        for entry in entries
    )
    head = "<tr><th>Time, s</th><th></th><th></th></tr>"
    return f'<div class="scroll"><table class="events"><thead>{head}</thead><tbody>{rows}</tbody></table></div>'


def _span(finding: Finding) -> str:
    if finding.from_s is None or finding.to_s is None:
        return ""
    return f"{finding.from_s:.1f} – {finding.to_s:.1f}"


def _evidence(finding: Finding) -> str:
    return ", ".join(
        f"{name} {value:.4g}" if isinstance(value, float) else f"{name} {value}" for name, value in finding.evidence.items()
    )

"""What the analysers found, the first thing in the report: what is wrong, not known, fine. Every text is escaped."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from html import escape

from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.tables import time_button
from flightapp.analysis.ulog.beside import LogBeside, findings_beside

NOT_KNOWN = "not known"


def findings_section(findings: Sequence[Finding], zero_s: float) -> str:
    """Worst first; what is fine is folded away, what is not known is not. Times are fleet time, shown from `zero_s` on."""
    if not findings:
        return '<section id="findings"><h2>Findings</h2><p class="note">Nothing was looked at.</p></section>'
    unknown = [one for one in findings if is_unknown(one)]
    known = [one for one in findings if not is_unknown(one)]
    wrong = sorted((one for one in known if one.severity > Severity.OK), key=lambda one: -one.severity)
    fine = [one for one in known if one.severity == Severity.OK]
    shown = _table(wrong, zero_s) if wrong else '<p class="note">No warning, no failure and nothing unusual was found.</p>'
    return (
        f'<section id="findings"><h2>Findings</h2><p class="note">{_counts(wrong, unknown, fine)} A time leads to the map.</p>'
        f"{shown}{_unknown(unknown)}{_fine(fine, zero_s)}</section>"
    )


def log_findings(logs: Sequence[LogBeside]) -> list[Finding]:
    """Of the autopilots' logs; of one that is not on the time line what is wrong in it, without a time."""
    found = []
    for log in logs:
        told = findings_beside([log])
        if log.alignment is None and log.examined is not None:
            wrong = (one for one in log.examined.findings if one.severity >= Severity.WARNING)
            told += [replace(one, from_s=None, to_s=None) for one in wrong]
        whose = log.path.name if log.vehicle is None else log.vehicle.name
        found += [replace(one, vehicle=whose, analyser=f"PX4 log, {one.analyser}".removesuffix(", PX4 log")) for one in told]
    return found


def is_unknown(finding: Finding) -> bool:
    """Whether the recording could not tell."""
    return finding.evidence.get("known") == "no"


def _counts(wrong: Sequence[Finding], unknown: Sequence[Finding], fine: Sequence[Finding]) -> str:
    counts = {severity: sum(one.severity == severity for one in wrong) for severity in (Severity.FAILURE, Severity.WARNING)}
    told = [f"{count} {severity.name.lower()}{'s' * (count != 1)}" for severity, count in counts.items()]
    notes = sum(one.severity == Severity.NOTE for one in wrong)
    return f"{', '.join(told)}, {notes} note{'s' * (notes != 1)}, {len(unknown)} not known, {len(fine)} fine."


def _unknown(findings: Sequence[Finding]) -> str:
    if not findings:
        return ""
    told: dict[tuple[str, str], list[str]] = {}
    for one in findings:
        told.setdefault((one.analyser, one.text), []).append(one.vehicle or "run")
    rows = "".join(
        f'<tr><td><span class="badge note">{NOT_KNOWN}</span></td><td>{escape(analyser)}</td>'
        f"<td>{escape(', '.join(vehicles))}</td><td>{escape(text)}</td></tr>"
        for (analyser, text), vehicles in told.items()
    )
    head = "<tr><th></th><th>Analyser</th><th>Vehicle</th><th>Why</th></tr>"
    return (
        '<h3 id="not-known">Not known</h3>'
        f'<div class="wide"><table class="findings"><thead>{head}</thead><tbody>{rows}</tbody></table></div>'
    )


def _fine(findings: Sequence[Finding], zero_s: float) -> str:
    if not findings:
        return ""
    return f"<details><summary>Looked at and fine ({len(findings)})</summary>{_table(findings, zero_s)}</details>"


def _table(findings: Sequence[Finding], zero_s: float) -> str:
    head = "<tr><th></th><th>Vehicle</th><th>Time, s</th><th>Analyser</th><th>Finding</th><th>Evidence</th></tr>"
    rows = "".join(_row(one, zero_s) for one in findings)
    return f'<div class="wide"><table class="findings"><thead>{head}</thead><tbody>{rows}</tbody></table></div>'


def _row(one: Finding, zero_s: float) -> str:
    severity = one.severity.name.lower()
    return (
        f'<tr><td><span class="badge {severity}">{severity}</span></td><td>{escape(one.vehicle or "run")}</td>'
        f"<td>{_span(one, zero_s)}</td><td>{escape(one.analyser)}</td>"
        f'<td class="finding"><strong>{escape(one.title)}</strong><br>{escape(one.text)}</td>'
        f'<td class="evidence">{_evidence(one)}</td></tr>'
    )


def _span(one: Finding, zero_s: float) -> str:
    if one.from_s is None:
        return ""
    start = time_button(one.from_s - zero_s)
    if one.to_s is None or one.to_s - one.from_s < 0.05:
        return start
    return f"{start} – {one.to_s - zero_s:.1f}"


def _evidence(one: Finding) -> str:
    return "<br>".join(
        f"{escape(name)} {value:.4g}" if isinstance(value, float) else f"{escape(name)} {escape(str(value))}"
        for name, value in one.evidence.items()
    )

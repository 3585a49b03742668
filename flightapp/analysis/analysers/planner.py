"""Planner: did it decide in time, and every time?"""

from __future__ import annotations

import numpy as np

from flightapp.analysis.analysers.analyser import PROFILE, Analyser
from flightapp.analysis.analysers.subject import Subject
from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.ulog.spans import Span, spans_of
from flightapp.core.types import Array
from flightapp.recording.phases import Window

NAME = "planner"
ALWAYS_LATE_S = 1.0
"""The failsafe table goes home when every decision has been late for so long."""
SHARE_LATE = 0.01
"""More than every hundredth decision late is no accident of the operating system."""
SILENT_PERIODS = 5.0
"""Setpoints without a decision for this many control periods: the planner raises, or somebody else flies."""
ENDING_S = 3.0
"""Once the outcome is known the vehicle brakes without the planner until it turns home: at top speed well within this time."""


def examine(subject: Subject) -> list[Finding]:
    if subject.pursuit is None:
        return [Finding(NAME, Severity.OK, "no pursuit", "There was no pursuit.", vehicle=subject.name)]
    return [*_late(subject, subject.pursuit), *_silent(subject, subject.pursuit)] or [_in_time(subject, subject.pursuit)]


def _late(subject: Subject, pursuit: Window) -> list[Finding]:
    decisions = subject.during("/decision", pursuit)
    latency, period_s = decisions.column("latency_s"), 1.0 / subject.profile.control.rate_min_hz
    late = latency > period_s
    if not late.any():
        return []
    share, worst_s = float(late.mean()), float(latency.max())
    spans = spans_of(decisions.t_s, late)
    longest_s = max(span.length_s for span in spans)
    severity = Severity.NOTE
    if longest_s > ALWAYS_LATE_S:
        severity = Severity.FAILURE
    elif share > SHARE_LATE:
        severity = Severity.WARNING
    text = (
        f"{np.count_nonzero(late)} of {len(late)} decisions took longer than the control period of {period_s * 1e3:.0f} ms, "
        f"the slowest {worst_s * 1e3:.0f} ms."
    )
    evidence: dict[str, float | str] = {"share": share, "latency_max_s": worst_s, "period_s": period_s, "longest_s": longest_s}
    return [Finding(NAME, severity, "decisions late", text, spans[0].from_s, spans[-1].to_s, evidence, subject.name)]


def _silent(subject: Subject, pursuit: Window) -> list[Finding]:
    """Gaps between decisions in which setpoints went on."""
    period_s = 1.0 / subject.profile.control.rate_min_hz
    decisions = subject.during("/decision", pursuit).t_s
    times = np.concatenate(([pursuit.start_s], decisions, [max(pursuit.start_s, pursuit.end_s - ENDING_S)]))
    gaps = [
        Span(float(times[index]), float(times[index + 1])) for index in np.flatnonzero(np.diff(times) > SILENT_PERIODS * period_s)
    ]
    setpoints = subject.topic("/setpoint").t_s
    silent = [gap for gap in gaps if _steady(setpoints, gap, period_s)]
    if not silent:
        return []
    longest = max(silent, key=lambda span: span.length_s)
    text = f"For {longest.length_s:.2f} s setpoints were sent without a decision: the planner failed, or was not asked."
    evidence = {"silent_s": longest.length_s}
    return [Finding(NAME, Severity.WARNING, "no decisions", text, longest.from_s, longest.to_s, evidence, subject.name)]


def _steady(setpoints_s: Array, gap: Span, period_s: float) -> bool:
    """Whether setpoints went on at half their rate or more."""
    count = np.count_nonzero((setpoints_s > gap.from_s) & (setpoints_s < gap.to_s))
    return bool(count > 0.5 * gap.length_s / period_s)


def _in_time(subject: Subject, pursuit: Window) -> Finding:
    decisions = subject.during("/decision", pursuit)
    slowest_s = float(np.nanmax(decisions.column("latency_s"), initial=0.0))
    text = f"{len(decisions)} decisions, the slowest took {slowest_s * 1e3:.1f} ms."
    evidence: dict[str, float | str] = {"latency_max_s": slowest_s, "decisions": float(len(decisions))}
    return Finding(NAME, Severity.OK, "decided in time", text, pursuit.start_s, pursuit.end_s, evidence, subject.name)


ANALYSER = Analyser(NAME, "Did the planner decide in time?", ("/decision", "/setpoint", PROFILE), examine)

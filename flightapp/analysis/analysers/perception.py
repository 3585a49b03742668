"""Perception: did depth frames come all the time, and did they show anything?"""

from __future__ import annotations

import numpy as np

from flightapp.analysis.analysers.analyser import PROFILE, Analyser
from flightapp.analysis.analysers.subject import Subject
from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.ulog.spans import Span, spans_of

NAME = "perception"
STANDSTILL_AGES = 3.0
"""The guards bring the vehicle to a standstill at this many times `safety.obstacles_age_max_s`."""
BLIND_S = 1.0
"""A whole circle unseen for longer is no single bad frame: 30 in a row at the camera's usual rate."""
WHOLE_CIRCLE_RAD = 2 * np.pi - 0.01


def examine(subject: Subject) -> list[Finding]:
    spans = subject.offboard
    if not spans:
        return [Finding(NAME, Severity.OK, "not needed", "There is no time in OFFBOARD.", vehicle=subject.name)]
    return [*_gap(subject, spans), *_blind(subject, spans), *_faults(subject, spans)] or [_steady(subject, spans)]


def _gap(subject: Subject, spans: list[Span]) -> list[Finding]:
    from_s, gap_s = _longest_gap(subject, spans)
    limit_s = subject.profile.safety.obstacles_age_max_s
    if gap_s <= limit_s:
        return []
    stood = gap_s > STANDSTILL_AGES * limit_s
    text = f"No depth frame for {gap_s:.2f} s; from {limit_s:g} s on the vehicle is slowed down" + (
        ", and it was stopped." * stood
    )
    text = text if stood else f"{text}."
    evidence: dict[str, float | str] = {"gap_s": gap_s, "limit_s": limit_s}
    severity = Severity.FAILURE if stood else Severity.WARNING
    return [Finding(NAME, severity, "depth frames missing", text, from_s, from_s + gap_s, evidence, subject.name)]


def _longest_gap(subject: Subject, spans: list[Span]) -> tuple[float, float]:
    """Start and length: between the times at which frames were used, from the start of OFFBOARD to its end."""
    best = (0.0, 0.0)
    for span in spans:
        times = np.concatenate(([span.from_s], subject.during("/obstacles", span).t_s, [span.to_s]))
        gaps = np.diff(times)
        if gaps.max() > best[1]:
            best = float(times[np.argmax(gaps)]), float(gaps.max())
    return best


def _blind(subject: Subject, spans: list[Span]) -> list[Finding]:
    """Frames come, but nothing in them can be believed: covers, glare, no pose."""
    for span in spans:
        frames = subject.during("/obstacles", span)
        unseen = np.array([sum(to - start for start, to in rows or ()) for rows in frames.values("unseen_rad")], dtype=np.float64)
        blind = spans_of(frames.t_s, unseen >= WHOLE_CIRCLE_RAD, least_s=BLIND_S)
        if blind:
            longest = max(blind, key=lambda one: one.length_s)
            text = f"For {longest.length_s:.1f} s the frames showed nothing in any direction."
            evidence: dict[str, float | str] = {"blind_s": longest.length_s}
            return [Finding(NAME, Severity.WARNING, "blind", text, longest.from_s, longest.to_s, evidence, subject.name)]
    return []


def _faults(subject: Subject, spans: list[Span]) -> list[Finding]:
    """What the camera said of itself."""
    for span in spans:
        frames = subject.during("/obstacles", span)
        told = [text for text in frames.texts("camera_fault") if text]
        restarts = frames.column("camera_restarts")
        restarted = float(np.nanmax(restarts) - np.nanmin(restarts)) if np.isfinite(restarts).any() else 0.0
        if told or restarted > 0:
            text = f"The camera had a fault: {told[0] if told else 'it was started again'} ({restarted:.0f} restarts)."
            evidence: dict[str, float | str] = {"restarts": restarted, "fault": told[0] if told else ""}
            return [Finding(NAME, Severity.WARNING, "camera fault", text, span.from_s, span.to_s, evidence, subject.name)]
    return []


def _steady(subject: Subject, spans: list[Span]) -> Finding:
    longest_s = _longest_gap(subject, spans)[1]
    text = f"The longest time without a new depth frame was {longest_s * 1e3:.0f} ms."
    return Finding(
        NAME, Severity.OK, "frames all the time", text, spans[0].from_s, spans[-1].to_s, {"gap_s": longest_s}, subject.name
    )


def _concerns(subject: Subject) -> bool:
    return subject.has_camera


ANALYSER = Analyser(NAME, "Did depth frames come, and show something?", ("/obstacles", "/autopilot", PROFILE), examine, _concerns)

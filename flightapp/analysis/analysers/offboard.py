"""Offboard: did the stream of setpoints hold, and who ended it?"""

from __future__ import annotations

import math

import numpy as np

from flightapp.analysis.analysers.analyser import PROFILE, Analyser
from flightapp.analysis.analysers.subject import Subject
from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.run import VehicleRun
from flightapp.analysis.ulog.spans import total_s

NAME = "offboard"
LOSS_S = 0.5
"""PX4 takes OFFBOARD for lost with fewer than two setpoints a second; MAVSDK's repeats would hide it from the autopilot, not
from us."""
SHARE_LATE = 0.01
HEARD_AFTER_S = 1.0
"""At most half a second of a recording is lost with its process, and a state is on its way for less than the other half."""
PILOT_MODES = ("MANUAL", "ALTCTL", "POSCTL", "STABILIZED", "ACRO", "RATTITUDE")
"""Modes that only a person takes: that is a warning, a failsafe of PX4 is a failure."""


def examine(subject: Subject) -> list[Finding]:
    if not subject.offboard:
        return [Finding(NAME, Severity.OK, "not flown in offboard", "There is no time in OFFBOARD.", vehicle=subject.name)]
    return [*_gaps(subject), *_late(subject), *_left(subject), *_cut(subject)] or [_held(subject)]


def _gaps(subject: Subject) -> list[Finding]:
    from_s, gap_s = _longest_gap(subject)
    deadman_s = subject.profile.control.deadman_timeout_s
    if gap_s <= deadman_s / 2:  # The other half is all that is left before the deadman kills the process.
        return []
    severity = Severity.FAILURE if gap_s > min(LOSS_S, deadman_s) else Severity.WARNING
    text = f"No setpoint for {gap_s:.2f} s; the deadman acts after {deadman_s:g} s and PX4 after {LOSS_S:g} s."
    evidence = {"gap_s": gap_s, "deadman_timeout_s": deadman_s}
    return [Finding(NAME, severity, "gap in the setpoints", text, from_s, from_s + gap_s, evidence, subject.name)]


def _longest_gap(subject: Subject) -> tuple[float, float]:
    """Start and length, within one stretch of OFFBOARD."""
    best = (0.0, 0.0)
    for span in subject.offboard:
        times = np.sort(subject.during("/setpoint", span).column("t_s"))
        gaps = np.diff(times)
        if len(gaps) and gaps.max() > best[1]:
            best = float(times[np.argmax(gaps)]), float(gaps.max())
    return best


def _late(subject: Subject) -> list[Finding]:
    """Every hundredth setpoint a whole control period late, second after second: the computer is too slow for its work."""
    health = subject.topic("/health")
    p99_ms, limit_ms = health.column("setpoint_gap_p99_ms"), 2e3 / subject.profile.control.rate_min_hz
    measured = np.isfinite(p99_ms)
    late = measured & (p99_ms > limit_ms)
    if np.count_nonzero(late) < 3 or np.count_nonzero(late) < SHARE_LATE * np.count_nonzero(measured):
        return []
    seconds, worst_ms = int(np.count_nonzero(late)), float(p99_ms[late].max())
    share = f"{seconds} of {len(p99_ms[measured])} s"
    text = f"In {share} the p99 of the setpoint gap was above {limit_ms:.0f} ms, {worst_ms:.0f} ms at worst."
    evidence: dict[str, float | str] = {"gap_p99_ms": worst_ms, "limit_ms": limit_ms, "seconds": float(seconds)}
    times = health.t_s[late]
    return [Finding(NAME, Severity.WARNING, "setpoints late", text, float(times[0]), float(times[-1]), evidence, subject.name)]


def _left(subject: Subject) -> list[Finding]:
    """Another mode was reported in the middle of the pursuit: the pilot, or a failsafe of PX4."""
    pursuit = subject.pursuit
    status = subject.topic("/autopilot")
    for span in subject.offboard:
        if pursuit is None:
            break
        inside = span.from_s < pursuit.end_s and span.to_s < pursuit.end_s
        after = np.flatnonzero(status.t_s >= span.to_s)
        if not inside or len(after) == 0:
            continue
        mode = status.texts("flight_mode")[after[0]]
        piloted = mode in PILOT_MODES
        text = f"The autopilot went from OFFBOARD to {mode} in the pursuit" + (
            ": a pilot took over." if piloted else " by itself."
        )
        severity = Severity.WARNING if piloted else Severity.FAILURE
        return [Finding(NAME, severity, "offboard left", text, span.to_s, pursuit.end_s, {"mode": mode}, subject.name)]
    return []


def _cut(subject: Subject) -> list[Finding]:
    """The recording ends in OFFBOARD: the process died, or only its file was cut, if others heard it fly on."""
    last, end_s = subject.offboard[-1], subject.vehicle.phases.end_s
    if last.to_s < end_s:
        return []
    heard_s = max((_heard_until_s(subject, other) for other in subject.run.vehicles), default=-math.inf)
    if heard_s > end_s + HEARD_AFTER_S:
        text = f"The recording ends in OFFBOARD, but others heard the vehicle for another {heard_s - end_s:.1f} s."
        evidence: dict[str, float | str] = {"heard_for_s": heard_s - end_s}
        return [Finding(NAME, Severity.WARNING, "recording cut off", text, end_s, end_s, evidence, subject.name)]
    text = "The recording ends while OFFBOARD was flown, and nobody heard the vehicle later: its process ended in flight."
    return [Finding(NAME, Severity.FAILURE, "ends in offboard", text, end_s, end_s, vehicle=subject.name)]


def _heard_until_s(subject: Subject, other: VehicleRun) -> float:
    """When the last state that `other` heard of the vehicle was true."""
    heard = Subject(subject.run, other).heard.get(subject.name)
    return -math.inf if heard is None else float((heard.t_s - heard.age_s).max())


def _held(subject: Subject) -> Finding:
    longest_s, flown_s = _longest_gap(subject)[1], total_s(subject.offboard)
    text = f"{flown_s:.1f} s in OFFBOARD, longest gap between two setpoints {longest_s * 1e3:.0f} ms."
    evidence: dict[str, float | str] = {"gap_s": longest_s, "flown_s": flown_s}
    first, last = subject.offboard[0], subject.offboard[-1]
    return Finding(NAME, Severity.OK, "offboard held", text, first.from_s, last.to_s, evidence, subject.name)


ANALYSER = Analyser(NAME, "Did the stream of setpoints hold?", ("/setpoint", "/autopilot", PROFILE), examine)

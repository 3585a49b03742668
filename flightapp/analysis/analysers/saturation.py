"""Saturation: did the vehicle fly what was asked of it, and was the limit asked for all the time?"""

from __future__ import annotations

import numpy as np

from flightapp.analysis.analysers.analyser import PROFILE, Analyser
from flightapp.analysis.analysers.subject import Subject
from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.ulog.spans import Span, spans_of
from flightapp.core.types import Array

NAME = "saturation"
AT_LIMIT = 0.98
"""Share of the top speed from which a setpoint counts as being at the limit."""
ERROR_SHARE = 0.3
"""Of the top speed. Sustained, it takes the vehicle more than the planner's margin off its way in ERROR_S."""
ERROR_S = 1.0
"""Longer than a change of direction at full speed takes with the profile's acceleration."""


def examine(subject: Subject) -> list[Finding]:
    spans = [span for span in subject.offboard if span.length_s > ERROR_S]
    if not spans:
        return [Finding(NAME, Severity.OK, "not flown in offboard", "There is no time in OFFBOARD.", vehicle=subject.name)]
    limit_m_s = ERROR_SHARE * subject.profile.limits.speed_max_m_s
    errors: list[float] = []
    at_limit: list[bool] = []
    off: list[Span] = []
    for span in spans:
        t_s, error_m_s, speed_m_s = _tracking(subject, span)
        errors += error_m_s.tolist()
        at_limit += (speed_m_s >= AT_LIMIT * subject.profile.limits.speed_max_m_s).tolist()
        off += spans_of(t_s, error_m_s > limit_m_s, least_s=ERROR_S)
    share, p95_m_s = float(np.mean(at_limit or [False])), float(np.percentile(errors or [0.0], 95))
    evidence: dict[str, float | str] = {"share_at_limit": share, "error_p95_m_s": p95_m_s, "limit_m_s": limit_m_s}
    if off:
        longest = max(off, key=lambda one: one.length_s)
        text = (
            f"For {longest.length_s:.1f} s the vehicle was more than {limit_m_s:.1f} m/s away from what was asked of it: "
            "wind, weak motors, limits that are lower in the autopilot, or a person at the sticks."
        )
        evidence["longest_s"] = longest.length_s
        return [
            Finding(NAME, Severity.WARNING, "setpoint not followed", text, longest.from_s, longest.to_s, evidence, subject.name)
        ]
    text = f"Velocity error {p95_m_s:.2f} m/s at the 95th percentile; {100 * share:.0f} % of the time at top speed."
    return [Finding(NAME, Severity.OK, "setpoints followed", text, spans[0].from_s, spans[-1].to_s, evidence, subject.name)]


def _tracking(subject: Subject, span: Span) -> tuple[Array, Array, Array]:
    """Times, planar error and commanded planar speed (n,); the answer to a setpoint is due `safety.response_lag_s` later.

    The smallest error at any delay up to twice the lag counts: an answer that comes early is no error.
    """
    setpoints, own = subject.during("/setpoint", span), subject.topic("/own")
    wanted, flown = setpoints.vectors("velocity_ned_m_s")[:, :2], own.vectors("velocity_ned_m_s")[:, :2]
    t_s, lag_s = setpoints.column("t_s"), subject.profile.safety.response_lag_s
    order = np.argsort(own.column("t_s"), kind="stable")
    own_s = own.column("t_s")[order]
    inside = t_s + 2 * lag_s <= min(span.to_s, own_s[-1])
    delays = np.linspace(0.0, 2 * lag_s, 5)
    errors = []
    for delay_s in delays:
        then = [np.interp(t_s[inside] + delay_s, own_s, flown[order, axis]) for axis in range(2)]
        errors.append(np.hypot(wanted[inside, 0] - then[0], wanted[inside, 1] - then[1]))
    return t_s[inside], np.min(errors, axis=0), np.hypot(wanted[inside, 0], wanted[inside, 1])


ANALYSER = Analyser(NAME, "Did it fly what was asked of it?", ("/setpoint", "/own", "/autopilot", PROFILE), examine)

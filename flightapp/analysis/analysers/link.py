"""Link: were the other vehicles heard while both flew?"""

from __future__ import annotations

import numpy as np

from flightapp.analysis.analysers.analyser import MISSION, PROFILE, Analyser
from flightapp.analysis.analysers.subject import Heard, Subject
from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.metrics import airborne
from flightapp.analysis.ulog.spans import spans_of
from flightapp.core.types import Array
from flightapp.recording.phases import Window

NAME = "link"
SHARE_LOST = 0.2
"""Of the states: every fifth may go missing before two in a row often do and the ages show it."""


def examine(subject: Subject) -> list[Finding]:
    return [_of(subject, other.name) for other in subject.mission.vehicles if other.name != subject.name]


def _of(subject: Subject, name: str) -> Finding:
    heard, window = subject.heard.get(name), _both_flew(subject, name)
    if window is None:
        text = f"{subject.name} and {name} never flew at the same time."
        return Finding(NAME, Severity.OK, f"{name} did not fly", text, evidence={"other": name}, vehicle=subject.name)
    if heard is None:
        text = f"{subject.name} never heard {name}, although both flew."
        evidence: dict[str, float | str] = {"other": name}
        return Finding(NAME, Severity.FAILURE, "never heard", text, window.start_s, window.end_s, evidence, subject.name)
    return _judged(subject, name, heard, window)


def _both_flew(subject: Subject, name: str) -> Window | None:
    """By both recordings; by the own one alone where the other is missing."""
    other = next((vehicle for vehicle in subject.run.vehicles if vehicle.name == name), None)
    theirs = subject.airborne if other is None else airborne(other)
    return None if theirs is None or subject.airborne is None else subject.airborne.common(theirs)


def _judged(subject: Subject, name: str, heard: Heard, window: Window) -> Finding:
    """Limits of the profile: beyond the first a state is not believed any more, beyond the second the link counts as lost."""
    safety = subject.profile.safety
    inside = (heard.t_s >= window.start_s) & (heard.t_s <= window.end_s) & (heard.is_done == 0)
    t_s, age_s, lost = heard.t_s[inside], heard.age_s[inside], heard.lost[inside]
    oldest_s = float(age_s.max(initial=0.0))
    gone = float(lost[-1] - lost[0]) if len(lost) else 0.0
    expected = _expected(heard.taken[inside], gone, window.length_s * subject.profile.network.state_rate_hz)
    evidence: dict[str, float | str] = {
        "other": name,
        "age_max_s": oldest_s,
        "lost_share": gone / max(expected, 1.0),
        "lost": gone,
    }
    if oldest_s > safety.team_state_age_max_s:
        spans = spans_of(t_s, age_s > safety.team_state_age_max_s)
        severity = Severity.FAILURE if oldest_s > safety.team_link_age_max_s else Severity.WARNING
        text = f"{name} was not heard for up to {oldest_s:.1f} s; after {safety.team_state_age_max_s:g} s it counts as silent."
        return Finding(NAME, severity, "teammate silent", text, spans[0].from_s, spans[-1].to_s, evidence, subject.name)
    if gone > SHARE_LOST * expected:
        text = f"{gone:.0f} of about {expected:.0f} states of {name} were lost."
        return Finding(NAME, Severity.WARNING, "messages lost", text, window.start_s, window.end_s, evidence, subject.name)
    p99_s = float(np.percentile(age_s, 99)) if len(age_s) else 0.0
    text = f"States of {name} were at most {oldest_s:.2f} s old (p99 {p99_s:.2f} s), {gone:.0f} lost."
    return Finding(NAME, Severity.OK, f"{name} heard", text, window.start_s, window.end_s, evidence, subject.name)


def _expected(taken: Array, gone: float, at_full_rate: float) -> float:
    """How many states were sent here: what came and what did not, fewer to a mate far away. Older recordings do not say."""
    known = taken[np.isfinite(taken)]
    return float(known[-1] - known[0]) + gone if len(known) else at_full_rate


def _concerns(subject: Subject) -> bool:
    """Not a run of a campaign: there nothing goes over a network."""
    told = subject.vehicle.recording.metadata.get("run", {})
    return told.get("network") != "none" and (subject.run.mission is None or len(subject.run.mission.vehicles) > 1)


ANALYSER = Analyser(NAME, "Were the others heard?", ("/team", MISSION, PROFILE), examine, _concerns)

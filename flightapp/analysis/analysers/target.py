"""Target: was the evader known all the time, and was the estimate right where that can be told?"""

from __future__ import annotations

import numpy as np

from flightapp.analysis.analysers.analyser import PROFILE, Analyser
from flightapp.analysis.analysers.subject import Subject
from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.track import track_of
from flightapp.analysis.ulog.spans import Span, spans_of
from flightapp.recording.phases import Window

NAME = "target"
GIVEN_UP_S = 30.0
"""The failsafe table goes home after this time without news of the evader."""
WRONG_S = 1.0
"""A shorter error is a turn that the filter has not followed yet."""
WRONG_SIGMAS = 3.0


def examine(subject: Subject) -> list[Finding]:
    if subject.pursuit is None:
        return [Finding(NAME, Severity.OK, "no pursuit", "There was no pursuit.", vehicle=subject.name)]
    return [*_lost(subject, subject.pursuit), *_wrong(subject, subject.pursuit)] or [_known(subject, subject.pursuit)]


def _lost(subject: Subject, pursuit: Window) -> list[Finding]:
    limit_s = subject.profile.safety.target_age_max_s
    lost = _without_news(subject, pursuit, limit_s)
    if not lost:
        return []
    longest = max(lost, key=lambda span: span.length_s)
    severity = Severity.FAILURE if longest.length_s > GIVEN_UP_S else Severity.WARNING
    times = "once" if len(lost) == 1 else f"{len(lost)} times"
    text = f"No news of the evader for longer than {limit_s:g} s, {times}, at worst {longest.length_s:.1f} s."
    evidence: dict[str, float | str] = {"lost_s": longest.length_s, "limit_s": limit_s, "times": float(len(lost))}
    return [Finding(NAME, severity, "evader lost", text, longest.from_s, longest.to_s, evidence, subject.name)]


def _without_news(subject: Subject, pursuit: Window, limit_s: float) -> list[Span]:
    """From the last news on, where the estimate became older than `limit_s`, or there was none."""
    series = subject.during("/target", pursuit)
    old = spans_of(series.t_s, series.column("age_s") > limit_s)
    silent = [Span(span.from_s - limit_s, span.to_s) for span in old]
    times = np.concatenate(([pursuit.start_s], series.t_s, [pursuit.end_s]))
    gaps = np.flatnonzero(np.diff(times) > limit_s)
    return silent + [Span(float(times[index]), float(times[index + 1])) for index in gaps]


def _wrong(subject: Subject, pursuit: Window) -> list[Finding]:
    """Against the evader's true or own states; a pursuer cannot capture what is elsewhere."""
    evaders = subject.run.with_role("evader")
    estimate = track_of(subject.during("/target", pursuit), "estimate")
    actual = evaders[0].track if evaders else None
    if estimate is None or actual is None or subject.run.mission is None:
        return []
    known = (estimate.t_s >= actual.t_s[0]) & (estimate.t_s <= actual.t_s[-1])
    times = estimate.t_s[known]
    errors = np.linalg.norm(estimate.position_ned_m[known, :2] - actual.at(times).position_ned_m[:, :2], axis=1)
    series = subject.during("/target", pursuit)
    sigma = np.interp(times, series.column("t_s"), series.column("position_sigma_m"))
    limit_m = np.maximum(subject.run.mission.capture.radius_m, WRONG_SIGMAS * sigma)
    wrong = spans_of(times, errors > limit_m, least_s=WRONG_S)
    if not wrong:
        return []
    worst_m = float(errors.max())
    text = f"The estimate was up to {worst_m:.1f} m off, more than the capture radius and {WRONG_SIGMAS:g} of its own sigmas."
    evidence: dict[str, float | str] = {"error_m": worst_m, "capture_radius_m": subject.run.mission.capture.radius_m}
    return [Finding(NAME, Severity.WARNING, "estimate wrong", text, wrong[0].from_s, wrong[-1].to_s, evidence, subject.name)]


def _known(subject: Subject, pursuit: Window) -> Finding:
    oldest_s = float(np.nanmax(subject.during("/target", pursuit).column("age_s"), initial=0.0))
    text = f"News of the evader was never older than {oldest_s:.2f} s."
    evidence = {"age_s": oldest_s}
    return Finding(NAME, Severity.OK, "evader known", text, pursuit.start_s, pursuit.end_s, evidence, subject.name)


def _concerns(subject: Subject) -> bool:
    return subject.is_pursuer


ANALYSER = Analyser(NAME, "Was the evader known, and rightly?", ("/target", PROFILE), examine, _concerns)

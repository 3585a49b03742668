"""Battery: what was left, and whether it fell suddenly."""

from __future__ import annotations

import numpy as np

from flightapp.analysis.analysers.analyser import PROFILE, Analyser, not_known
from flightapp.analysis.analysers.subject import Subject
from flightapp.analysis.findings import Finding, Severity

NAME = "battery"
FALL = 0.1
FALL_S = 5.0
"""A tenth of the charge within five seconds would empty the battery in fifty: a cell or its measurement has failed."""


def examine(subject: Subject) -> list[Finding]:
    assert subject.airborne is not None
    series = subject.during("/battery", subject.airborne)
    told = series.column("remaining_fraction")
    known = np.isfinite(told)
    if not known.any():
        return [not_known(NAME, subject, "the autopilot did not tell its charge in flight")]
    t_s, left = series.t_s[known], told[known]
    return [*_low(subject, t_s, left), *_fallen(subject, t_s, left)] or [_enough(subject, left)]


def _low(subject: Subject, t_s: np.ndarray, left: np.ndarray) -> list[Finding]:
    """The reserve is what must be left after the way home; below the critical charge a vehicle lands where it is."""
    safety = subject.profile.safety
    reserve, critical, least = safety.battery_reserve_fraction, safety.battery_critical_fraction, float(left.min())
    if least >= reserve:
        return []
    severity, title = (Severity.FAILURE, "battery critical") if least < critical else (Severity.WARNING, "reserve used")
    text = (
        f"{100 * least:.0f} % was left in flight; the reserve is {100 * reserve:.0f} %, critical is below {100 * critical:.0f} %."
    )
    below_s = t_s[left < reserve]
    evidence: dict[str, float | str] = {"left_fraction": least, "reserve_fraction": reserve, "critical_fraction": critical}
    return [Finding(NAME, severity, title, text, float(below_s[0]), float(below_s[-1]), evidence, subject.name)]


def _fallen(subject: Subject, t_s: np.ndarray, left: np.ndarray) -> list[Finding]:
    later = np.minimum(np.searchsorted(t_s, t_s + FALL_S, side="right") - 1, len(t_s) - 1)
    fall = left - left[later]
    worst = int(np.argmax(fall))
    if fall[worst] < FALL:
        return []
    text = f"The charge fell from {100 * left[worst]:.0f} to {100 * left[later[worst]]:.0f} % within {FALL_S:g} s."
    evidence: dict[str, float | str] = {"fall_fraction": float(fall[worst]), "window_s": FALL_S}
    span = float(t_s[worst]), float(t_s[later[worst]])
    return [Finding(NAME, Severity.WARNING, "charge fell suddenly", text, *span, evidence, subject.name)]


def _enough(subject: Subject, left: np.ndarray) -> Finding:
    text = f"{100 * left[0]:.0f} % at take-off, {100 * left.min():.0f} % at the least."
    evidence: dict[str, float | str] = {"left_fraction": float(left.min()), "start_fraction": float(left[0])}
    return Finding(NAME, Severity.OK, "charge enough", text, evidence=evidence, vehicle=subject.name)


ANALYSER = Analyser(NAME, "Was the charge enough?", ("/battery", PROFILE), examine)

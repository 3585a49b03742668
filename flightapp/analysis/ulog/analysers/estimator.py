"""The estimator: did it know where it was, did it jump, did it reject its sensors?"""

from __future__ import annotations

import numpy as np

from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.ulog.analyser import Analyser, not_known
from flightapp.analysis.ulog.log import FlightLog, Topic
from flightapp.analysis.ulog.spans import Mask, Span, spans_of, total_s, within

NAME = "estimator"
LASTING_S = 0.5
RATIOS = {"pos": "position", "vel": "velocity", "hgt": "height", "mag": "magnetometer", "hdg": "heading"}
"""Innovation test ratios of estimator_status: above 1 the measurement is rejected."""
RESETS = {
    "xy_reset_counter": "horizontal position",
    "vxy_reset_counter": "horizontal velocity",
    "z_reset_counter": "height",
    "heading_reset_counter": "heading",
}


def examine(log: FlightLog) -> list[Finding]:
    local, status = log.topic("vehicle_local_position"), log.topic("estimator_status")
    airborne = log.airborne()
    if local is None or status is None or not airborne:
        return [not_known(NAME, "vehicle_land_detected shows no flight")]
    inside = within(local.t_s, airborne)
    if not inside.any():
        return [not_known(NAME, "no position was logged in flight")]
    found = [*_lost(local, inside), *_jumps(local, airborne), *_rejections(status, airborne), *_faults(status, airborne)]
    return found or [_healthy(local, inside)]


def _lost(local: Topic, inside: Mask) -> list[Finding]:
    found = []
    for column, bad, title in (
        ("xy_valid", 0, "horizontal position lost"),
        ("v_xy_valid", 0, "horizontal velocity lost"),
        ("z_valid", 0, "height lost"),
        ("dead_reckoning", 1, "dead reckoning"),
    ):
        values = local.column(column)
        when = [] if values is None else spans_of(local.t_s, inside & (values == bad))
        if when:
            text = f"For {total_s(when):.1f} s in flight ({column} = {bad})."
            found.append(Finding(NAME, Severity.FAILURE, title, text, when[0].from_s, when[-1].to_s, {"lasted_s": total_s(when)}))
    return found


def _jumps(local: Topic, airborne: tuple[Span, ...]) -> list[Finding]:
    found = []
    inside = within(local.t_s, airborne)
    for column, what in RESETS.items():
        counter = local.column(column)
        steps = None if counter is None else np.flatnonzero((np.diff(counter) != 0) & inside[1:]) + 1
        if steps is None or not len(steps):
            continue
        first, last = float(local.t_s[steps[0]]), float(local.t_s[steps[-1]])
        text = f"The estimator reset its {what} {len(steps)} time{'s'[: len(steps) > 1]} in flight, first at {first:.1f} s."
        found.append(Finding(NAME, Severity.WARNING, f"{what} reset", text, first, last, {"resets": float(len(steps))}))
    return found


def _rejections(status: Topic, airborne: tuple[Span, ...]) -> list[Finding]:
    found = []
    inside = within(status.t_s, airborne)
    for key, what in RATIOS.items():
        ratio = status.column(f"{key}_test_ratio")
        if ratio is None:
            continue
        when = spans_of(status.t_s, inside & (np.nan_to_num(ratio) > 1.0), least_s=LASTING_S)
        if when:
            most = float(np.nanmax(ratio[inside]))
            text = f"{what.capitalize()} measurements were rejected for {total_s(when):.1f} s; test ratio {most:.2f} at worst."
            evidence = {"test_ratio_max": most, "rejected_s": total_s(when)}
            found.append(Finding(NAME, Severity.WARNING, f"{what} rejected", text, when[0].from_s, when[-1].to_s, evidence))
    return found


def _faults(status: Topic, airborne: tuple[Span, ...]) -> list[Finding]:
    flags = status.column("filter_fault_flags")
    when = [] if flags is None else spans_of(status.t_s, within(status.t_s, airborne) & (flags != 0))
    if flags is None or not when:
        return []
    text = f"filter_fault_flags was {int(flags.max()):#x} for {total_s(when):.1f} s in flight."
    return [
        Finding(NAME, Severity.FAILURE, "estimator fault", text, when[0].from_s, when[-1].to_s, {"flags": float(flags.max())})
    ]


def _healthy(local: Topic, inside: Mask) -> Finding:
    eph = local.column("eph")
    how = "" if eph is None else f", horizontally to {np.nanmax(eph[inside]):.2f} m at worst by its own account"
    return Finding(NAME, Severity.OK, "position held", f"Position and velocity were valid all the flight{how}; no reset.")


ANALYSER = Analyser(NAME, ("vehicle_local_position", "estimator_status", "vehicle_land_detected"), examine)

"""Vibration of the inertial sensors, and clipping."""

from __future__ import annotations

import numpy as np

from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.ulog.analyser import Analyser, not_known
from flightapp.analysis.ulog.log import FlightLog, Topic
from flightapp.analysis.ulog.spans import Mask, within

NAME = "vibration"
RAISED_M_S2, HIGH_M_S2 = 4.905, 9.81
"""Bands of PX4's Flight Review for accel_vibration_metric."""
AXES = ("x", "y", "z")


def examine(log: FlightLog) -> list[Finding]:
    found: list[Finding] = []
    levels: list[float] = []
    for number, topic in enumerate(log.topics["vehicle_imu_status"]):
        inside = within(topic.t_s, log.airborne())
        metric = topic.column("accel_vibration_metric")
        if metric is None or not inside.any():
            continue
        levels.append(float(np.percentile(metric[inside], 95)))
        found += [*_level(number, levels[-1], float(metric[inside].max())), *_clipping(number, topic, inside)]
    if not levels:
        return [not_known(NAME, "no vibration was logged in flight")]
    text = f"95 % of the flight below {max(levels):.1f} m/s² (raised from {RAISED_M_S2:g})."
    return found or [Finding(NAME, Severity.OK, "vibration low", text, evidence={"accel_vibration_p95_m_s2": max(levels)})]


def _level(number: int, level: float, most: float) -> list[Finding]:
    if level < RAISED_M_S2:
        return []
    severity, word = (Severity.WARNING, "high") if level >= HIGH_M_S2 else (Severity.NOTE, "raised")
    text = (
        f"Accelerometer {number}: {level:.1f} m/s² is exceeded 5 % of the flight, {most:.1f} at most (high from {HIGH_M_S2:g})."
    )
    evidence = {"accel_vibration_p95_m_s2": level, "accel_vibration_max_m_s2": most}
    return [Finding(NAME, severity, f"vibration {word}", text, evidence=evidence)]


def _clipping(number: int, topic: Topic, inside: Mask) -> list[Finding]:
    counts = topic.vectors([f"accel_clipping[{axis}]" for axis in range(3)])
    if counts is None:
        return []
    clipped = counts[inside][-1] - counts[inside][0]
    if not (clipped > 0).any():
        return []
    told = ", ".join(f"{axis} {count:.0f}" for axis, count in zip(AXES, clipped.tolist(), strict=True))
    text = (
        f"Accelerometer {number} reached the end of its range in flight (samples: {told}): the estimate cannot be trusted then."
    )
    return [Finding(NAME, Severity.WARNING, "accelerometer clipping", text, evidence={"samples": float(clipped.sum())})]


ANALYSER = Analyser(NAME, ("vehicle_imu_status", "vehicle_land_detected"), examine)

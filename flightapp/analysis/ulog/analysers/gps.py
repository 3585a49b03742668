"""GPS: fix, accuracy, and what the receiver says of jamming and spoofing."""

from __future__ import annotations

import numpy as np

from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.ulog.analyser import Analyser, not_known
from flightapp.analysis.ulog.log import FlightLog, Topic
from flightapp.analysis.ulog.spans import Mask, Span, spans_of, total_s, within

NAME = "GPS"
FIX_3D = 3
LASTING_S = 1.0
INTERFERENCE_RAISED, INTERFERENCE_HIGH = 40.0, 80.0
"""u-blox jamming indicator, 0 to 255: PX4's log-analysis guide wants 40 or less, and the set-up inspected from 80."""
SATELLITES_MIN = 6
"""EKF2_REQ_NSATS"""
EPH_MAX_M = 5.0
"""COM_POS_FS_EPH: beyond, PX4 calls the position lost."""


def examine(log: FlightLog) -> list[Finding]:
    topic = log.topic("vehicle_gps_position") or log.topic("sensor_gps")
    if topic is None:
        return [not_known(NAME, "no position of a receiver was logged")]
    inside = within(topic.t_s, log.airborne() or log.armed() or (Span(topic.t_s[0], log.end_s),))
    if not inside.any():
        return [not_known(NAME, "no position of a receiver was logged in flight")]
    found = [*_fix(log, topic, inside), *_interference(topic, inside), *_attack(topic, inside), *_accuracy(topic, inside)]
    return found or [_healthy(topic, inside)]


def is_used(log: FlightLog) -> bool:
    """Whether the estimator was told to use it (EKF2_GPS_CTRL, or EKF2_AID_MASK before PX4 1.14)."""
    return log.parameters.get("EKF2_GPS_CTRL", log.parameters.get("EKF2_AID_MASK", 1.0)) != 0.0


def _fix(log: FlightLog, topic: Topic, inside: Mask) -> list[Finding]:
    fix = topic.column("fix_type")
    if fix is None:
        return [not_known(f"{NAME} fix", "the kind of fix was not logged")]
    lost = spans_of(topic.t_s, inside & (fix < FIX_3D), least_s=LASTING_S)
    if not lost:
        return []
    satellites = _range(topic, "satellites_used", inside)
    whole = bool((fix[inside] < FIX_3D).all())
    used = is_used(log)
    seen = "" if satellites is None else f" {satellites[1]:.0f} satellites at most were used."
    consequence = (
        " The estimator was set to use GPS."
        if used
        else " The estimator was set not to use GPS, so the flight did not depend on it, but home and return to launch did."
    )
    return [
        Finding(
            NAME,
            Severity.FAILURE if used else Severity.WARNING,
            "no GPS fix for the whole flight" if whole else "GPS fix lost",
            f"No 3D fix for {total_s(lost):.1f} s in flight.{seen}{consequence}",
            lost[0].from_s,
            lost[-1].to_s,
            {"without_fix_s": total_s(lost), "satellites_max": -1.0 if satellites is None else satellites[1]},
        )
    ]


def _interference(topic: Topic, inside: Mask) -> list[Finding]:
    indicator = topic.column("jamming_indicator")
    if indicator is None:
        return []
    most, middle = float(indicator[inside].max()), float(np.median(indicator[inside]))
    if most <= INTERFERENCE_RAISED:
        return []
    high = spans_of(topic.t_s, inside & (indicator > INTERFERENCE_RAISED))
    text = (
        f"The receiver's jamming indicator was {indicator[inside].min():.0f} to {most:.0f} of 255 (median {middle:.0f}): "
        f"{INTERFERENCE_RAISED:g} or less is usual, from {INTERFERENCE_HIGH:g} the set-up must be inspected. Usual sources: "
        "USB 3, the companion computer, video and telemetry transmitters beside the antenna."
    )
    severity = Severity.FAILURE if middle >= INTERFERENCE_HIGH else Severity.WARNING
    noise = _range(topic, "noise_per_ms", inside)
    evidence = {"jamming_indicator_max": most, "jamming_indicator_median": middle}
    evidence |= {} if noise is None else {"noise_per_ms_max": noise[1]}
    return [Finding(NAME, severity, "GPS interference", text, high[0].from_s, high[-1].to_s, evidence)]


def _attack(topic: Topic, inside: Mask) -> list[Finding]:
    """The receiver's own verdict: 0 not known, 1 none, 2 suspected or mitigated, 3 certain."""
    found = []
    for column, word in (("jamming_state", "jamming"), ("spoofing_state", "spoofing")):
        state = topic.column(column)
        if state is not None and (state[inside] >= 2).any():
            when = spans_of(topic.t_s, inside & (state >= 2))
            severity = Severity.FAILURE if state[inside].max() >= 3 else Severity.WARNING
            text = f"The receiver reported {word} (state {state[inside].max():.0f} of 3) for {total_s(when):.1f} s."
            evidence = {column: float(state[inside].max())}
            found.append(Finding(NAME, severity, f"{word} reported", text, when[0].from_s, when[-1].to_s, evidence))
    return found


def _accuracy(topic: Topic, inside: Mask) -> list[Finding]:
    fix = topic.column("fix_type")
    fixed = inside if fix is None else inside & (fix >= FIX_3D)
    found = []
    eph, satellites = topic.column("eph"), topic.column("satellites_used")
    if eph is not None and (poor := spans_of(topic.t_s, fixed & (eph > EPH_MAX_M), least_s=LASTING_S)):
        most = float(eph[fixed].max())
        text = f"The horizontal accuracy was worse than {EPH_MAX_M:g} m for {total_s(poor):.1f} s, {most:.1f} m at worst."
        found.append(Finding(NAME, Severity.FAILURE, "GPS inaccurate", text, poor[0].from_s, poor[-1].to_s, {"eph_max_m": most}))
    if satellites is not None and (few := spans_of(topic.t_s, fixed & (satellites < SATELLITES_MIN), least_s=LASTING_S)):
        least = float(satellites[fixed].min())
        text = f"Fewer than {SATELLITES_MIN} satellites for {total_s(few):.1f} s, {least:.0f} at the fewest."
        found.append(
            Finding(NAME, Severity.WARNING, "few satellites", text, few[0].from_s, few[-1].to_s, {"satellites_min": least})
        )
    return found


def _healthy(topic: Topic, inside: Mask) -> Finding:
    satellites, eph = _range(topic, "satellites_used", inside), _range(topic, "eph", inside)
    parts = [] if satellites is None else [f"{satellites[0]:.0f} to {satellites[1]:.0f} satellites"]
    parts += [] if eph is None else [f"{eph[1]:.2f} m at worst"]
    return Finding(
        NAME, Severity.OK, "fix held", f"A 3D fix all the time: {', '.join(parts)}." if parts else "A 3D fix all the time."
    )


def _range(topic: Topic, name: str, inside: Mask) -> tuple[float, float] | None:
    values = topic.column(name)
    return None if values is None else (float(values[inside].min()), float(values[inside].max()))


ANALYSER = Analyser(NAME, ("vehicle_gps_position|sensor_gps",), examine)

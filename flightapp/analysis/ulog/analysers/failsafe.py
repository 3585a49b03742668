"""PX4's own failsafe: when it acted, and which of its conditions held in flight."""

from __future__ import annotations

from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.ulog.analyser import Analyser
from flightapp.analysis.ulog.log import FlightLog, Topic
from flightapp.analysis.ulog.spans import Span, spans_of, total_s, within

NAME = "failsafe"
_FLAGS: tuple[tuple[Severity, tuple[str, ...]], ...] = (
    (
        Severity.FAILURE,
        (
            *("angular_velocity_invalid", "attitude_invalid", "local_altitude_invalid", "local_velocity_invalid"),
            *("geofence_breached", "primary_geofence_breached", "battery_unhealthy", "navigator_failure"),
            *("fd_critical_failure", "fd_esc_arming_failure", "fd_motor_failure"),
        ),
    ),
    (
        Severity.WARNING,
        (
            *("manual_control_signal_lost", "battery_warning", "battery_low_remaining_time", "fd_imbalanced_prop"),
            *("wind_limit_exceeded", "flight_time_limit_exceeded", "local_position_accuracy_low"),
            *("position_accuracy_low", "local_position_invalid_relaxed", "mission_failure"),
        ),
    ),
    (Severity.NOTE, ("global_position_invalid", "home_position_invalid")),
)
"""By how bad they are in flight. Offboard and ground-station flags have analysers of their own; a missing mission is no fault."""


def examine(log: FlightLog) -> list[Finding]:
    airborne = log.airborne() or log.armed()
    found = _acted(log, airborne)
    flags = log.topic("failsafe_flags")
    for severity, names in _FLAGS:
        found += [] if flags is None else _held(flags, severity, names, airborne)
    return found


def _acted(log: FlightLog, airborne: tuple[Span, ...]) -> list[Finding]:
    found = []
    status = log.topic("vehicle_status")
    for column, title in (("failsafe", "PX4's failsafe acted"), ("failure_detector_status", "PX4's failure detector tripped")):
        values = None if status is None else status.column(column)
        when = [] if status is None or values is None else spans_of(status.t_s, within(status.t_s, airborne) & (values != 0))
        if when:
            text = f"For {total_s(when):.1f} s in flight (vehicle_status.{column})."
            found.append(Finding(NAME, Severity.FAILURE, title, text, when[0].from_s, when[-1].to_s))
    return found


def _held(flags: Topic, severity: Severity, names: tuple[str, ...], airborne: tuple[Span, ...]) -> list[Finding]:
    found = []
    for name in names:
        values = flags.column(name)
        # Flags are published twice a second and on change: the last value before the flight holds into it.
        when = [] if values is None else _overlap(spans_of(flags.t_s, values == 1), airborne)
        if when:
            title = name.replace("fd_", "failure detector: ").replace("_", " ")
            text = f"For {total_s(when):.1f} s in flight (failsafe_flags.{name})."
            found.append(Finding(NAME, severity, title, text, when[0].from_s, when[-1].to_s, {"lasted_s": total_s(when)}))
    return found


def _overlap(spans: list[Span], others: tuple[Span, ...]) -> list[Span]:
    common = [Span(max(a.from_s, b.from_s), min(a.to_s, b.to_s)) for a in spans for b in others]
    return [span for span in common if span.length_s > 0.0]


ANALYSER = Analyser(NAME, ("vehicle_status", "failsafe_flags"), examine)

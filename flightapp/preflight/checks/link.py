"""Is the autopilot heard, and often enough?"""

from __future__ import annotations

from flightapp.preflight.facts import Facts
from flightapp.preflight.result import Level, Result

NAME = "link"
REASON = "the control loop flies by this telemetry; a link that loses it loses setpoints too"
RATE_FRACTION_MIN = 0.8
MEASURED_AFTER_S = 3.0
GAP_MAX_S = 0.15
"""Own motion is carried forward over less than this; see `pose_history.EXTRAPOLATION_MAX_S`."""
CHECK_CABLE = "check cable, baud rate and MAV_0_RATE; lower autopilot.telemetry_rate_hz if the link cannot carry it"


def judge(facts: Facts) -> tuple[Result, ...]:
    details, wanted_hz = facts.details, facts.profile.autopilot.telemetry_rate_hz
    if not facts.status.connected:
        level = Level.RUNNING if facts.waited_s < MEASURED_AFTER_S else Level.FAILED  # heartbeats come once a second
        return (Result(NAME, level, "no heartbeat", REASON, "check cable, power and autopilot.connection_url"),)
    found = f"state {details.state_rate_hz:.0f} Hz, attitude {details.attitude_rate_hz:.0f} Hz of {wanted_hz:g} Hz"
    if details.telemetry_gap_s is not None:
        found += f", longest gap {details.telemetry_gap_s * 1e3:.0f} ms"
    if min(details.state_rate_hz, details.attitude_rate_hz) < RATE_FRACTION_MIN * wanted_hz:
        level, remedy = Level.FAILED, CHECK_CABLE
    elif details.telemetry_gap_s is not None and details.telemetry_gap_s > GAP_MAX_S:
        level, remedy = Level.WARNING, f"it stutters; {CHECK_CABLE}"
    else:
        return (Result(NAME, Level.PASSED, found, REASON),)
    return (Result(NAME, Level.RUNNING if facts.waited_s < MEASURED_AFTER_S else level, found, REASON, remedy),)

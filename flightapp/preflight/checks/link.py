"""Is the autopilot heard, and often enough?"""

from __future__ import annotations

from flightapp.preflight.facts import Facts
from flightapp.preflight.result import Level, Result

NAME = "link"
REASON = "the control loop flies by this telemetry; a link that loses it loses setpoints too"
RATE_FRACTION_MIN = 0.8
MEASURED_AFTER_S = 3.0
CHECK_CABLE = "check cable, baud rate and MAV_0_RATE; lower autopilot.telemetry_rate_hz if the link cannot carry it"


def judge(facts: Facts) -> tuple[Result, ...]:
    details, wanted_hz = facts.details, facts.profile.autopilot.telemetry_rate_hz
    if not facts.status.connected:
        return (Result(NAME, Level.FAILED, "no heartbeat", REASON, "check cable, power and autopilot.connection_url"),)
    found = f"state {details.state_rate_hz:.0f} Hz, attitude {details.attitude_rate_hz:.0f} Hz of {wanted_hz:g} Hz"
    if min(details.state_rate_hz, details.attitude_rate_hz) >= RATE_FRACTION_MIN * wanted_hz:
        return (Result(NAME, Level.PASSED, found, REASON),)
    level = Level.RUNNING if facts.waited_s < MEASURED_AFTER_S else Level.FAILED
    return (Result(NAME, level, found, REASON, CHECK_CABLE),)

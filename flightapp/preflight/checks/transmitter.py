"""Can the pilot take over?"""

from __future__ import annotations

from flightapp.preflight.facts import Facts
from flightapp.preflight.result import Level, Result

NAME = "transmitter"
REASON = "the pilot's sticks are the last word over everything that this app does"


def judge(facts: Facts) -> tuple[Result, ...]:
    seen = facts.details.transmitter_seen
    if not facts.profile.autopilot.pilot_transmitter:
        return (Result(NAME, Level.SKIPPED, "autopilot.pilot_transmitter = false: nobody stands by", REASON),)
    if seen is None:
        remedy = "move a stick and look for it in a ground station"
        return (Result(NAME, Level.WARNING, "the autopilot does not tell whether it is received", REASON, remedy),)
    if not seen:
        return (Result(NAME, Level.FAILED, "not received", REASON, "switch it on; check binding and COM_RC_IN_MODE"),)
    return (Result(NAME, Level.PASSED, "received", REASON),)

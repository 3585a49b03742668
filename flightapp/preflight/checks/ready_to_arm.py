"""Does the autopilot itself say that it can be armed?"""

from __future__ import annotations

from flightapp.preflight.facts import Facts
from flightapp.preflight.result import Level, Result

NAME = "health"
REASON = "the autopilot refuses to arm otherwise"


def judge(facts: Facts) -> tuple[Result, ...]:
    status, health = facts.status, facts.health
    if status.armed or status.landed_state not in ("ON_GROUND", "UNKNOWN"):
        found = f"armed {status.armed}, {status.landed_state}"
        return (Result(NAME, Level.FAILED, found, "a preflight is for a vehicle on the ground", "land and disarm it"),)
    missing = health.missing()
    if missing or status.landed_state == "UNKNOWN":
        waiting = ", ".join((*missing, *(() if status.landed_state != "UNKNOWN" else ("landed state",))))
        return (Result(NAME, Level.RUNNING, f"not yet: {waiting}", REASON, "wait; then read the autopilot's own messages"),)
    return (Result(NAME, Level.PASSED, "ready to arm", REASON),)

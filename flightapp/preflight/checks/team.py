"""Is everybody here, with the same mission?"""

from __future__ import annotations

from flightapp.preflight.facts import Facts
from flightapp.preflight.result import Level, Result

NAME = "team"
MISSION = "mission-file"
REASON = "vehicles that do not hear each other do not keep apart"
AGE_MAX_S = 1.0


def judge(facts: Facts) -> tuple[Result, ...]:
    if not facts.teammates:
        return (Result(NAME, Level.SKIPPED, "a mission for one vehicle", REASON),)
    absent = [mate.name for mate in facts.teammates if mate.age_s is None or mate.age_s > AGE_MAX_S]
    heard = [mate for mate in facts.teammates if mate.age_s is not None and mate.age_s <= AGE_MAX_S]
    present = ", ".join(mate.name for mate in heard) or "nobody"
    results = []
    if absent:
        remedy = "start them; check network.listen_endpoints and connect_endpoints: every vehicle names every other one"
        results.append(Result(NAME, Level.RUNNING, f"heard {present}; not heard: {', '.join(absent)}", REASON, remedy))
    else:
        results.append(Result(NAME, Level.PASSED, f"heard {present}", REASON))
    others = [mate.name for mate in heard if mate.mission_digest != facts.mission_digest]
    reason = "all vehicles must mean the same places and times"
    if others:
        found = f"{', '.join(others)} fly another version"
        results.append(Result(MISSION, Level.FAILED, found, reason, "copy one mission file to all vehicles"))
    elif heard:
        results.append(Result(MISSION, Level.PASSED, f"{facts.mission_digest} on all that are heard", reason))
    return tuple(results)

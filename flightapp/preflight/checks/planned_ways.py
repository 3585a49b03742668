"""Is there a way to the station, and home from there, around what is known?"""

from __future__ import annotations

from flightapp.preflight.facts import Facts
from flightapp.preflight.result import Level, Result

NAME = "planned-ways"
REASON = "a vehicle that finds no way after take-off has flown for nothing"
_REMEDY = "move station or start, or correct known_obstacles"


def judge(facts: Facts) -> tuple[Result, ...]:
    if not facts.ways:
        return (Result(NAME, Level.SKIPPED, "the mission plans no ingress for this vehicle", REASON),)
    missing = [way.text for way in facts.ways if not way.is_found]
    if missing:
        return (Result(NAME, Level.FAILED, "; ".join(missing), REASON, _REMEDY),)
    return (Result(NAME, Level.PASSED, "; ".join(way.text for way in facts.ways), REASON),)

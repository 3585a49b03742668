"""Does the vehicle know well enough where it is?"""

from __future__ import annotations

import math

from flightapp.preflight.facts import Facts
from flightapp.preflight.result import Level, Result

NAME = "position"
REASON = "separation and fence are kept in a frame that all vehicles share: an error of one is a gap for the other"
FIX_3D = 3
FIXES = {0: "no receiver", 1: "no fix", 2: "2-D fix", 3: "3-D fix", 4: "DGPS fix", 5: "RTK float", 6: "RTK fixed"}
"""MAVLink GPS_FIX_TYPE."""


def judge(facts: Facts) -> tuple[Result, ...]:
    accuracy, limit_m = facts.details.accuracy, facts.profile.preflight.position_accuracy_max_m
    if facts.motion is None or accuracy is None:
        return (Result(NAME, Level.RUNNING, "no position yet", REASON, "wait under open sky"),)
    found = f"{accuracy.satellites} satellites, {FIXES.get(accuracy.fix, f'fix {accuracy.fix}')}"
    if math.isfinite(accuracy.horizontal_m):
        found += f", +-{accuracy.horizontal_m:.1f} m, height +-{accuracy.vertical_m:.1f} m"
    if accuracy.fix < FIX_3D or accuracy.horizontal_m > limit_m:
        remedy = f"wait under open sky for a 3-D fix of +-{limit_m:g} m or better (preflight.position_accuracy_max_m)"
        return (Result(NAME, Level.RUNNING, found, REASON, remedy),)
    if math.isnan(accuracy.horizontal_m):
        return (Result(NAME, Level.NOTED, f"{found}; this receiver does not tell its accuracy", REASON),)
    return (Result(NAME, Level.PASSED, found, REASON),)

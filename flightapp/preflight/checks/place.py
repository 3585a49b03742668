"""Does the vehicle stand where the mission has it start, and is its home there?"""

from __future__ import annotations

import math

from flightapp.preflight.facts import Facts
from flightapp.preflight.result import Level, Result

NAME = "start"
REASON = "a vehicle that stands elsewhere has the wrong mission, the wrong datum or the wrong name"
DISTANCE_MAX_M = 10.0
HEIGHT_MAX_M = 5.0
HOME_MAX_M = 5.0
REMEDY = "carry it to its start, or correct datum and start in the mission"


def judge(facts: Facts) -> tuple[Result, ...]:
    if facts.motion is None:
        return (Result(NAME, Level.RUNNING, "no position yet", REASON, "wait for a position"),)
    start = facts.vehicle.start
    north, east, down = (float(value) for value in facts.motion.state.position_ned_m)
    away_m = math.hypot(north - start.north_m, east - start.east_m)
    above_m = -down - start.ground_height_m
    found = f"{away_m:.1f} m from its start, {above_m:+.1f} m in height"
    if away_m > DISTANCE_MAX_M or abs(above_m) > HEIGHT_MAX_M:
        return (Result(NAME, Level.FAILED, f"{found}; at most {DISTANCE_MAX_M:g} m and {HEIGHT_MAX_M:g} m", REASON, REMEDY),)
    return (Result(NAME, Level.PASSED, found, REASON), _home(facts, north, east))


def _home(facts: Facts, north_m: float, east_m: float) -> Result:
    name, reason = "home", "return flies there"
    home = facts.details.home_ned_m
    if home is None:
        return Result(name, Level.RUNNING, "not set yet", reason, "wait; the autopilot sets it with its first good position")
    off_m = math.hypot(home[0] - north_m, home[1] - east_m)
    if off_m > HOME_MAX_M:
        remedy = "restart the autopilot here, or set home in a ground station"
        return Result(name, Level.FAILED, f"{off_m:.1f} m away from the vehicle", reason, remedy)
    return Result(name, Level.PASSED, f"{off_m:.1f} m away from the vehicle", reason)

"""Is there enough charge for this mission?"""

from __future__ import annotations

from flightapp.preflight.facts import Facts
from flightapp.preflight.result import Level, Result

NAME = "battery"
REASON = "the mission, the way home and its reserve are flown on it"
FULL_FRACTION = 0.9


def judge(facts: Facts) -> tuple[Result, ...]:
    battery, least = facts.battery, facts.profile.preflight.battery_start_min_fraction
    if battery is None:
        return (Result(NAME, Level.RUNNING, "not reported yet", REASON, "wait; then check the power module"),)
    if battery.remaining_fraction is None:
        found = "no charge reported" if battery.voltage_v is None else f"{battery.voltage_v:.1f} V, no charge reported"
        return (Result(NAME, Level.WARNING, found, REASON, "calibrate the battery in the autopilot (BAT1_*)"),)
    found = f"{battery.remaining_fraction:.0%}" + ("" if battery.voltage_v is None else f", {battery.voltage_v:.1f} V")
    if battery.remaining_fraction < least:
        remedy = f"change it; at least {least:.0%} (preflight.battery_start_min_fraction) is needed"
        return (Result(NAME, Level.FAILED, found, REASON, remedy),)
    if battery.remaining_fraction < FULL_FRACTION:
        return (Result(NAME, Level.NOTED, f"{found}: not full", REASON),)
    return (Result(NAME, Level.PASSED, found, REASON),)

"""Is this the vehicle that the mission means, and the only one with its system id?"""

from __future__ import annotations

from flightapp.preflight.facts import Facts
from flightapp.preflight.result import Level, Result

NAME = "system-id"
REASON = "two vehicles with one system id obey each other's commands"


def judge(facts: Facts) -> tuple[Result, ...]:
    own = facts.vehicle.system_id
    same = [mate.name for mate in facts.teammates if mate.system_id == own]
    if same:
        found = f"{own}, as {', '.join(same)}"
        return (Result(NAME, Level.FAILED, found, REASON, "give every autopilot its own MAV_SYS_ID and enter it in the mission"),)
    if facts.details.twin:
        return (Result(NAME, Level.FAILED, facts.details.twin, REASON, "find the other autopilot on this link, change its id"),)
    others = [heard for heard in facts.details.system_ids_heard if heard != own]
    if others:
        return (Result(NAME, Level.NOTED, f"{own}; also heard on this link: {', '.join(map(str, others))}", REASON),)
    return (Result(NAME, Level.PASSED, f"{own}", REASON),)

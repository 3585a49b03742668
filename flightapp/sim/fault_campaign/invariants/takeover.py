"""A pilot is never fought."""

from __future__ import annotations

import math
from collections.abc import Iterator

from flightapp.sim.fault_campaign.trace import Finding, Takeover, Trace, VehicleTrace

ENDING_S = 0.1
"""From the news of another mode to the last setpoint or command: what was under way, and one control period."""
REPEATS_END_S = 2.0
"""MAVSDK's own repeats end with the next heartbeats."""
ENDS_MISSION = ("rtl", "land", "abort")


def takeover(trace: Trace) -> Iterator[Finding]:
    """From the moment at which the app can know of a takeover it sends no setpoint and no command that arms or changes the
    mode, until an operator asks for one; and OFFBOARD is never asked for again.
    """
    for one in trace.vehicles.values():
        for taken in one.takeovers:
            if taken.heard_s is not None:
                yield from _after(one, taken, taken.heard_s)


def _after(one: VehicleTrace, taken: Takeover, heard_s: float) -> Iterator[Finding]:
    wished = [wish.t_s for wish in one.wishes if wish.accepted and wish.action in ENDS_MISSION and wish.t_s >= taken.t_s]
    released_until_s = min(wished, default=math.inf)
    begins_s = heard_s + ENDING_S
    for kind, times_s, from_s in (
        ("a setpoint", [sent.t_s for sent in one.setpoints], begins_s),
        ("a repeated setpoint", one.transmitted_s, heard_s + REPEATS_END_S),
    ):
        late = [t_s for t_s in times_s if from_s < t_s < released_until_s]
        if late:
            yield Finding(one.name, late[0], f"{kind} {late[0] - taken.t_s:.2f} s after the pilot took over")
    for t_s, what in one.commands:
        if begins_s < t_s < released_until_s or (t_s > begins_s and what == "OFFBOARD"):
            yield Finding(one.name, t_s, f"commands '{what}' {t_s - taken.t_s:.2f} s after the pilot took over")
            return

"""No contact with an obstacle."""

from __future__ import annotations

import math
from collections.abc import Iterator

from flightapp.sim.fault_campaign.attribution import answers_until_s
from flightapp.sim.fault_campaign.trace import Finding, Trace
from flightapp.sim.world import World


def obstacle_contact(trace: Trace) -> Iterator[Finding]:
    """No armed vehicle's body touches an obstacle while the app answers for where it flies."""
    world = World(trace.mission.obstacles)
    for one in trace.vehicles.values():
        until_s, radius = answers_until_s(trace, one.name), one.limits.body_radius_m
        deepest, at_s = math.inf, 0.0
        for row, before, armed in zip(one.states[1:], one.states, one.armed[1:], strict=False):
            if row[0] >= until_s:
                break
            if armed and world.signed_distance_m(row[1], row[2], row[3]) < radius + 0.2:
                clearance = world.segment_clearance_m(before[1:4], row[1:4], radius)
                if clearance < deepest:
                    deepest, at_s = clearance, float(row[0])
        if deepest <= 0.0:
            yield Finding(one.name, at_s, f"touches an obstacle, {-deepest:.2f} m deep")

"""Everybody comes down."""

from __future__ import annotations

from collections.abc import Iterator

from flightapp.sim.fault_campaign.trace import Finding, Trace


def on_the_ground(trace: Trace) -> Iterator[Finding]:
    """At the end every vehicle stands disarmed, or a pilot has it."""
    for one in trace.vehicles.values():
        if one.is_piloted or (one.on_ground[-1] and not one.armed[-1]):
            continue
        found = "armed on the ground" if one.on_ground[-1] else "still in the air"
        yield Finding(one.name, float(one.states[-1, 0]), f"{found} at the end{f': {one.error}' if one.error else ''}")

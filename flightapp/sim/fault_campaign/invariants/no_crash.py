"""Nothing breaks that was not broken on purpose."""

from __future__ import annotations

from collections.abc import Iterator

from flightapp.sim.fault_campaign.trace import Finding, Trace


def no_crash(trace: Trace) -> Iterator[Finding]:
    """No task of a vehicle ends by an exception, no control period fails, no task, thread or process outlives the mission."""
    for one in trace.vehicles.values():
        for text in one.crashes:
            yield Finding(one.name, None, text)
    for text in trace.leftovers:
        yield Finding("", None, text)

"""No record is lost."""

from __future__ import annotations

from collections.abc import Iterator

from flightapp.sim.fault_campaign.trace import Finding, Trace


def recordings(trace: Trace) -> Iterator[Finding]:
    """Every vehicle's recording can be read and holds something; that of a killed process is cut off and must be recoverable."""
    for one in trace.vehicles.values():
        if one.is_recorded and not one.recordings:
            yield Finding(one.name, None, "no recording")
        for check in one.recordings:
            if check.error or not check.messages:
                yield Finding(one.name, None, f"{check.path.name}: {check.error or 'holds no message'}")

"""A takeover is seen at once."""

from __future__ import annotations

from collections.abc import Iterator

from flightapp.sim.fault_campaign.trace import Finding, Trace

SEEN_S = 0.2
HIDING = ("link", "killed", "hung", "mode")
"""Faults that may hide the pilot's mode from the app."""


def takeover_seen(trace: Trace) -> Iterator[Finding]:
    """The app knows of a takeover within 0.2 s, unless a fault of the link hides it or its process is dead."""
    for one in trace.vehicles.values():
        hidden = any(report.vehicle == one.name and report.kind.startswith(HIDING) for report in trace.injections)
        for taken in one.takeovers:
            if not hidden and (taken.heard_s is None or taken.heard_s - taken.t_s > SEEN_S):
                found = "never" if taken.heard_s is None else f"{taken.heard_s - taken.t_s:.2f} s later"
                yield Finding(one.name, taken.t_s, f"the pilot took over; the app heard of it {found}")

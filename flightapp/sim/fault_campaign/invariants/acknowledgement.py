"""Operators are answered."""

from __future__ import annotations

from collections.abc import Iterator

from flightapp.sim.fault_campaign.trace import Finding, Trace

ANSWER_S = 0.2


def acknowledgement(trace: Trace) -> Iterator[Finding]:
    """Every operator command that can reach a living vehicle is answered within 0.2 s, accepted or not."""
    for one in trace.vehicles.values():
        for wish in one.wishes:
            if wish.is_reachable and (wish.answered_s is None or wish.answered_s - wish.t_s > ANSWER_S):
                found = "not at all" if wish.answered_s is None else f"after {wish.answered_s - wish.t_s:.2f} s"
                yield Finding(one.name, wish.t_s, f"command '{wish.action}' answered {found}")

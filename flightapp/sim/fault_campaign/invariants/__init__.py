"""What must hold after every mission: one small file each, a function from a trace to what is wrong."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from flightapp.sim.fault_campaign.invariants.acknowledgement import acknowledgement
from flightapp.sim.fault_campaign.invariants.contingency import contingency
from flightapp.sim.fault_campaign.invariants.limits import limits
from flightapp.sim.fault_campaign.invariants.no_crash import no_crash
from flightapp.sim.fault_campaign.invariants.obstacle_contact import obstacle_contact
from flightapp.sim.fault_campaign.invariants.on_the_ground import on_the_ground
from flightapp.sim.fault_campaign.invariants.recordings import recordings
from flightapp.sim.fault_campaign.invariants.takeover import takeover
from flightapp.sim.fault_campaign.invariants.takeover_seen import takeover_seen
from flightapp.sim.fault_campaign.invariants.vehicle_contact import vehicle_contact
from flightapp.sim.fault_campaign.trace import Finding, Trace

Invariant = Callable[[Trace], Iterator[Finding]]

INVARIANTS: dict[str, Invariant] = {
    "contingency volume": contingency,
    "setpoint limits": limits,
    "obstacle contact": obstacle_contact,
    "vehicle contact": vehicle_contact,
    "takeover": takeover,
    "takeover seen": takeover_seen,
    "acknowledgement": acknowledgement,
    "recordings": recordings,
    "on the ground": on_the_ground,
    "no crash": no_crash,
}

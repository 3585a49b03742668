"""No contact between vehicles."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from flightapp.core.types import Array
from flightapp.sim.fault_campaign.attribution import answers_until_s
from flightapp.sim.fault_campaign.trace import Finding, Trace, VehicleTrace

CLOSING_M_S = 0.2
"""Who moves towards the other more slowly has been hit, and has not hit."""


def vehicle_contact(trace: Trace) -> Iterator[Finding]:
    """No two vehicles in the air touch. The app answers for a pursuer that moves towards the other at that moment and that it
    still answers for. An evader plays the adversary: its policy may ram.
    """
    for one, other in combinations(trace.vehicles.values(), 2):
        step = _first_contact(one, other)
        if step is None:
            continue
        t_s, reach = float(one.states[step, 0]), one.limits.body_radius_m + other.limits.body_radius_m
        apart = float(np.linalg.norm(one.states[step, 1:4] - other.states[step, 1:4]))
        for own, met in ((one, other), (other, one)):
            if own.vehicle.role != "pursuer" or t_s >= answers_until_s(trace, own.name):
                continue
            if _closing_m_s(own.states[step], met.states[step]) > CLOSING_M_S:
                yield Finding(own.name, t_s, f"touches {met.name}: centres {apart:.2f} m apart, bodies reach {reach:.2f} m")


def _first_contact(one: VehicleTrace, other: VehicleTrace) -> int | None:
    """The step at which two bodies in the air first touch."""
    steps = min(len(one.states), len(other.states))
    apart = np.linalg.norm(one.states[:steps, 1:4] - other.states[:steps, 1:4], axis=1)
    flying = ~(one.on_ground[:steps] | other.on_ground[:steps])
    touching = np.flatnonzero(flying & (apart < one.limits.body_radius_m + other.limits.body_radius_m))
    return int(touching[0]) if touching.size else None


def _closing_m_s(own: Array, other: Array) -> float:
    """Speed of `own` towards the place of `other`."""
    way = other[1:4] - own[1:4]
    return float(own[4:7] @ way / max(float(np.linalg.norm(way)), 1e-6))

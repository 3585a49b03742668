"""Avoidance inside the control loop: push away from what is approached, and the manoeuvre for what nothing else can avoid.

Specification 2.7. Bodies as `flightapp.space.bodies`; a clearance is what is left between the vehicle's hull and a surface.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numba

from flightapp.control.flat import FlatGains
from flightapp.control.observer import VECTOR
from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.space.bodies import BODIES
from flightapp.space.contact import first_contact
from flightapp.space.distance import body_gap, signed_distance_and_gradient


@dataclass(frozen=True, slots=True)
class AvoidanceGains(FlatGains):
    """In the order of the kernels' array; the constants below name the places."""

    repulsion: float = 100.0
    repulsion_weight: float = 1.2
    range_min_m: float = 8.0
    speed_reference_m_s: float = 10.0
    standing: float = 0.0
    """Share of the push that does not depend on the closing speed; 1 is the source's, which pushes as hard at a crawl."""
    hull_m: float = 0.25
    safety_m: float = 1.0
    braking_m_s2: float = 3.6
    """What can be counted on: 0.6 of the largest acceleration."""
    reaction_s: float = 0.15
    acceleration_max_m_s2: float = 6.0
    deviation_m: float = 1.0
    """Nearer than this to its reference the vehicle is on a way that has been checked: no emergency."""


(
    REPULSION,
    WEIGHT,
    RANGE,
    SPEED_REFERENCE,
    STANDING,
    HULL,
    SAFETY,
    BRAKING,
    REACTION,
    ACCELERATION_MAX,
    DEVIATION,
) = range(11)
DISTANCE_MIN_M = 0.2
HORIZON_SPARE_S = 0.5
BLEND_S = 0.1
CALM_S = 0.5
CALM_M = 0.5
ESCAPE_SHARE = 0.5

ACTIVE, CALM_FOR, BLENDED, ENTRIES = 0, 1, 2, 5
EMERGENCY_SIZE = 6
"""Whether it acts, for how long all has been calm, the smoothed acceleration (3), how often it began (ask for a new path)."""


@compiled(numba.void(VECTOR, BODIES, VECTOR, VECTOR, VECTOR))
def push_away(gains: Array, bodies: Array, position: Array, velocity: Array, push: Array) -> None:
    """push (3,): acceleration away from all bodies in range that are approached; nothing from those that are left behind.

    The range is what braking from the closing speed takes, at least `range_min_m`. Within `safety` + 0.5 m everything pushes.
    """
    push[0] = push[1] = push[2] = 0.0
    for i in range(bodies.shape[0]):
        gap, n, e, d = body_gap(bodies, i, position[0], position[1], position[2])
        clearance = gap - gains[HULL]
        closing = max(0.0, -(velocity[0] * n + velocity[1] * e + velocity[2] * d))
        reach = max(gains[RANGE], closing * closing / (2.0 * gains[BRAKING]) + closing * gains[REACTION])
        near = clearance < gains[SAFETY] + CALM_M
        left = max(DISTANCE_MIN_M, clearance - gains[SAFETY])
        if left >= reach or not (closing > 0.0 or near):
            continue
        standing = 1.0 if clearance < gains[SAFETY] else gains[STANDING]
        share = standing + closing / gains[SPEED_REFERENCE]
        size = gains[REPULSION] * gains[WEIGHT] * (1.0 / left - 1.0 / reach) / (left * left) * share
        size = min(size, gains[ACCELERATION_MAX])
        push[0] += size * n
        push[1] += size * e
        push[2] += size * d


@compiled(numba.boolean(VECTOR, BODIES, VECTOR, VECTOR, VECTOR, numba.float64, numba.float64, VECTOR))
def flee(
    gains: Array,
    bodies: Array,
    state: Array,
    position: Array,
    velocity: Array,
    off_m: float,
    dt_s: float,
    push: Array,
) -> bool:
    """Whether the emergency manoeuvre acts; push (3,) is then its acceleration, never towards the nearest body.

    It begins off the reference (`off_m`), where a body would be hit and the vehicle could not stop before it. It ends when the
    clearance is `safety` + 0.5 m and nothing is in the way, for the whole of 0.5 s. state (EMERGENCY_SIZE,).
    """
    speed = math.sqrt(velocity[0] ** 2 + velocity[1] ** 2 + velocity[2] ** 2)
    horizon_s = speed / gains[BRAKING] + gains[REACTION] + HORIZON_SPARE_S
    hit_s, which = first_contact(
        bodies, position[0], position[1], position[2], velocity[0], velocity[1], velocity[2], 0.0, gains[HULL], horizon_s
    )
    gap, n, e, d = signed_distance_and_gradient(bodies, position[0], position[1], position[2], 0.0)
    clearance = gap - gains[HULL]
    stopping_m = speed * speed / (2.0 * gains[BRAKING]) + speed * gains[REACTION]
    unstoppable = which >= 0 and stopping_m > speed * hit_s
    if state[ACTIVE] == 0.0:
        if not (unstoppable and (off_m > gains[DEVIATION] or clearance < gains[SAFETY])):
            return False
        state[ACTIVE], state[CALM_FOR] = 1.0, 0.0
        state[BLENDED] = state[BLENDED + 1] = state[BLENDED + 2] = 0.0
        state[ENTRIES] += 1.0
    calm = clearance >= gains[SAFETY] + CALM_M and which < 0
    state[CALM_FOR] = state[CALM_FOR] + dt_s if calm else 0.0
    if state[CALM_FOR] >= CALM_S:
        state[ACTIVE] = 0.0
        return False
    hit_n, hit_e, hit_d = n, e, d
    if which >= 0:
        _, hit_n, hit_e, hit_d = body_gap(
            bodies,
            which,
            position[0] + velocity[0] * hit_s,
            position[1] + velocity[1] * hit_s,
            position[2] + velocity[2] * hit_s,
        )
    blend = 1.0 - math.exp(-dt_s / BLEND_S)
    into = velocity[0] * hit_n + velocity[1] * hit_e + velocity[2] * hit_d
    away = (hit_n, hit_e, hit_d)
    nearest = (n, e, d)
    along = 0.0
    for k in range(3):
        aside = (velocity[k] - into * away[k]) / max(speed, 1e-6)
        state[BLENDED + k] += blend * (away[k] + ESCAPE_SHARE * aside - state[BLENDED + k])
        along += state[BLENDED + k] * nearest[k]
    size = 0.0
    for k in range(3):
        push[k] = state[BLENDED + k] - min(0.0, along) * nearest[k]
        size += push[k] ** 2
    scale = gains[ACCELERATION_MAX] / max(1.0, math.sqrt(size))
    for k in range(3):
        push[k] *= scale
    return True

"""The source's own way of moving: a step of fixed length along the force, on a moving scene, until the goal or the last step."""

from __future__ import annotations

import math

import numba
from numpy.typing import NDArray

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.adaptive_apf.escape import (
    FORCE_SHARE,
    PUSH_D,
    PUSH_E,
    PUSH_N,
    TRIED,
    TRIES,
    UNTIL,
    begin_escape,
    escape_direction,
    is_trapped,
)
from flightapp.planning.adaptive_apf.field import FORCE, GAIN, PUSH, REACH_OUT, sum_forces
from flightapp.planning.adaptive_apf.forces import attraction
from flightapp.planning.adaptive_apf.gains import GAINS, Gains
from flightapp.space.bodies import BODIES, EAST, INDICES, LENGTH, NORTH, NUMBER, ROW, V_DOWN, V_EAST, V_NORTH
from flightapp.space.bodies import BOTTOM as BODY_BOTTOM
from flightapp.space.bodies import TOP as BODY_TOP
from flightapp.space.distance import nearest_bodies

ARRIVED, COLLIDED, ENDED = 0, 1, 2
STEP_S = 0.02
"""Of one iteration: what turns the source's metres a step into metres a second."""
OUTCOME = numba.types.UniTuple(numba.int64, 3)  # type: ignore[no-untyped-call]


@compiled(numba.void(BODIES, ROW, NUMBER))
def _move(bodies: Array, phases: Array, period: float) -> None:
    """Every body one step on, and back after `period` steps: a triangle wave."""
    for i in range(bodies.shape[0]):
        bodies[i, NORTH] += STEP_S * bodies[i, V_NORTH]
        bodies[i, EAST] += STEP_S * bodies[i, V_EAST]
        bodies[i, BODY_TOP] += STEP_S * bodies[i, V_DOWN]
        bodies[i, BODY_BOTTOM] += STEP_S * bodies[i, V_DOWN]
        phases[i] += 1.0
        if phases[i] >= period:
            phases[i] = 0.0
            for column in (V_NORTH, V_EAST, V_DOWN):
                bodies[i, column] = -bodies[i, column]


@compiled(
    OUTCOME(
        BODIES, ROW, NUMBER, ROW, ROW, GAINS, NUMBER, NUMBER, numba.boolean, NUMBER, BODIES, BODIES, INDICES, BODIES, BODIES,
        ROW, BODIES, ROW,
    )
)  # fmt: skip
def fly_steps(
    bodies: Array,
    phases: Array,
    period: float,
    start: Array,
    goal: Array,
    gains: Gains,
    step_m: float,
    tolerance_m: float,
    escapes: bool,
    inertia: float,
    draws: Array,
    path: Array,
    which: NDArray,  # type: ignore[type-arg]
    gaps: Array,
    tracks: Array,
    trap: Array,
    past: Array,
    field: Array,
) -> tuple[int, int, int]:
    """(outcome, steps, escapes begun); path (m + 1, 4) gets the places, and how far the nearest body's surface is from the
    vehicle's there; m steps at most. The bodies move in `bodies` itself.

    phases (n,): steps since each body turned back, every `period` steps; draws (j, 3): Gaussian numbers for the escapes in turn.
    inertia: 0: along the force at once (the source); else the force is an acceleration, damped by this much per second.
    which (k,), gaps (k, 4), tracks (n, TRACK_COLUMNS), trap, past, field: room, zeros at the start.
    """
    place = start.copy()
    velocity = field[:3] * 0.0
    begun = 0
    path[0, 0], path[0, 1], path[0, 2], path[0, 3] = place[0], place[1], place[2], math.inf
    speed = step_m / STEP_S
    for step in range(path.shape[0] - 1):
        t_s = step * STEP_S
        count = nearest_bodies(bodies, place[0], place[1], place[2], 0.0, math.inf, which, gaps)
        sum_forces(bodies, which, gaps, count, place, velocity, start, goal, tracks, gains, t_s, STEP_S, field)
        n, e, d = field[FORCE], field[FORCE + 1], field[FORCE + 2]
        an, ae, ad = goal[0] - place[0], goal[1] - place[1], goal[2] - place[2]
        left = math.sqrt(an * an + ae * ae + ad * ad)
        if escapes:
            radius = gains.body_radius_m
            if is_trapped(trap, past, bodies, which, count, place, goal, radius, speed, tolerance_m, t_s):
                draw = begun % draws.shape[0]
                spread = 0.5 * 1.5 ** trap[TRIED]
                if trap[TRIED] >= TRIES:
                    trap[TRIED] = 0.0
                un, ue, ud = escape_direction(
                    field[PUSH], field[PUSH + 1], field[PUSH + 2], an, ae, ad, draws[draw, 0], draws[draw, 1], draws[draw, 2],
                    spread,
                )  # fmt: skip
                begin_escape(trap, un, ue, ud, (bodies[which[0], LENGTH] + field[REACH_OUT]) / speed, t_s)
                begun += 1
            if t_s < trap[UNTIL]:
                pn, pe, pd = attraction(an, ae, ad, gains)
                size = FORCE_SHARE * math.sqrt(pn * pn + pe * pe + pd * pd)
                n, e, d = n + size * trap[PUSH_N], e + size * trap[PUSH_E], d + size * trap[PUSH_D]
        force = math.sqrt(n * n + e * e + d * d)
        length = min(step_m * (1.0 + field[GAIN]), left)
        if inertia > 0.0:
            n = velocity[0] + STEP_S * (n - inertia * velocity[0])
            e = velocity[1] + STEP_S * (e - inertia * velocity[1])
            d = velocity[2] + STEP_S * (d - inertia * velocity[2])
            force = math.sqrt(n * n + e * e + d * d)
            length = min(length, force * STEP_S)
        share = length / force if force > 1e-12 else 0.0
        place[0], place[1], place[2] = place[0] + share * n, place[1] + share * e, place[2] + share * d
        velocity[0], velocity[1], velocity[2] = share * n / STEP_S, share * e / STEP_S, share * d / STEP_S
        path[step + 1, 0], path[step + 1, 1], path[step + 1, 2] = place[0], place[1], place[2]
        _move(bodies, phases, period)
        nearest_bodies(bodies, place[0], place[1], place[2], 0.0, math.inf, which, gaps)
        path[step + 1, 3] = gaps[0, 0] - gains.body_radius_m if bodies.shape[0] > 0 else math.inf
        if path[step + 1, 3] < 0.0:
            return COLLIDED, step + 1, begun
        n, e, d = goal[0] - place[0], goal[1] - place[1], goal[2] - place[2]
        if math.sqrt(n * n + e * e + d * d) < tolerance_m:
            return ARRIVED, step + 1, begun
    return ENDED, path.shape[0] - 1, begun

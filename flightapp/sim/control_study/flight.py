"""One flight of a formation as a kernel: plant, wind, controllers, avoidance, and everything that is measured.

The plant is the source's double integrator, moved every STEP_S; with a lag and a delay it stands for a vehicle under PX4. Frame:
NED; bodies stand still.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from flightapp.control.avoidance import ACCELERATION_MAX as PUSH_MAX
from flightapp.control.avoidance import EMERGENCY_SIZE, HULL, flee, push_away
from flightapp.control.cascade import decide_cascade
from flightapp.control.formation import SMOOTHING, adapted_gain, repel
from flightapp.control.law import decide
from flightapp.control.observer import DISTURBANCE, observe
from flightapp.control.printed import decide_printed
from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.sim.wind import air_velocity, height_factor
from flightapp.space.bodies import BODIES
from flightapp.space.distance import signed_distance

STEP_S = 0.001
LAW, PRINTED, CASCADE = 0, 1, 2
LIMITED_FROM = 0.999
"""Share of the squared limit from which a command counts as limited."""
STATE_SIZE = 32
"""Of any controller."""
DELAY_STEPS_MAX = 128
CHECK_STEPS = 10
"""Clearances are measured so often."""
AVOID_STEPS = 20
"""What pushes on a vehicle is renewed so often."""

KIND, PERIOD_STEPS, LAG_S, DELAY_STEPS, ACCELERATION_MAX, DRAG, AVOIDS, REFERENCE_S, SETTLED_S = range(9)
PLANT_SIZE = 9
"""Controller, its period and the command's delay in steps, actuator lag, limit, wind's push per air speed (1/s), whether it
avoids bodies and teammates, spacing of the reference's rows, and from when an error counts as steady."""

(
    ERROR,
    ERROR_SQUARED,
    ERROR_MAX,
    STEADY,
    STEADY_COUNT,
    COUNT,
    LIMITED,
    CLEARANCE,
    PAIR_MIN,
    NEAREST_MEAN,
    PAIR_MEAN,
    PAIR_SQUARED,
    PAIR_MAX,
    SPACING_COUNT,
    FORMATION,
    FORMATION_SQUARED,
    FORMATION_MAX,
    FORMATION_COUNT,
    GAIN_MAX,
    EMERGENCIES,
    MISSED_GOAL,
    DISTURBANCE_MAX,
    PAIR_MEAN_MIN,
    PAIR_NOW,
    NEAREST_NOW,
    FORMATION_NOW,
) = range(26)
MEASURES = 26
"""Sums, counts and extremes over the flight, and the last values of three; `flown.measured` makes means of them."""

PLACES_FROM = 25
"""Of the leader: time, reference (3), position (3), velocity (3), error (3), its rate (3), command (3), disturbance as estimated
(3); then mean distance of a pair, smallest one, mean distance of followers from their places; from here on the position (3) of
every vehicle."""
_ROWS = BODIES
_VECTOR = numba.float64[::1]
_LAYERS = numba.float64[:, :, ::1]


@compiled(numba.void(_LAYERS, numba.int64, numba.float64, numba.float64, _VECTOR))
def reference_at(references: Array, i: int, t_s: float, spacing_s: float, out: Array) -> None:
    """out (9,): position, velocity, acceleration of vehicle `i` between the rows of references (n, m, 9); the last row stays."""
    last = references.shape[1] - 1
    place = min(t_s / spacing_s, float(last))
    row = min(int(place), last - 1)
    share = place - row
    for k in range(9):
        out[k] = (1.0 - share) * references[i, row, k] + share * references[i, row + 1, k]


@compiled(numba.void(_VECTOR, _ROWS, _ROWS, _ROWS))
def _measure_formation(measures: Array, positions: Array, bodies: Array, wanted: Array) -> None:
    """Distances between the vehicles and of followers from their places beside the leader."""
    n = positions.shape[0]
    total, pairs, nearest_sum, off_sum = 0.0, 0, 0.0, 0.0
    measures[NEAREST_NOW] = math.inf
    for i in range(n):
        nearest = math.inf
        for j in range(n):
            if i == j:
                continue
            squared = 0.0
            for k in range(3):
                squared += (positions[i, k] - positions[j, k]) ** 2
            distance = math.sqrt(squared)
            nearest = min(nearest, distance)
            if j < i:
                total += distance
                pairs += 1
        nearest_sum += nearest
        measures[PAIR_MIN] = min(measures[PAIR_MIN], nearest)
        measures[NEAREST_NOW] = min(measures[NEAREST_NOW], nearest)
        clearance = signed_distance(bodies, positions[i, 0], positions[i, 1], positions[i, 2], 0.0)
        measures[CLEARANCE] = min(measures[CLEARANCE], clearance)
        if i > 0:
            squared = 0.0
            for k in range(3):
                squared += (positions[i, k] - positions[0, k] - wanted[i, k] + wanted[0, k]) ** 2
            off = math.sqrt(squared)
            off_sum += off
            measures[FORMATION] += off
            measures[FORMATION_SQUARED] += squared
            measures[FORMATION_MAX] = max(measures[FORMATION_MAX], off)
            measures[FORMATION_COUNT] += 1.0
    if n > 1:
        mean = total / pairs
        measures[PAIR_NOW], measures[FORMATION_NOW] = mean, off_sum / (n - 1)
        measures[NEAREST_MEAN] += nearest_sum / n
        measures[PAIR_MEAN] += mean
        measures[PAIR_SQUARED] += mean * mean
        measures[PAIR_MAX] = max(measures[PAIR_MAX], mean)
        measures[PAIR_MEAN_MIN] = min(measures[PAIR_MEAN_MIN], mean)
        measures[SPACING_COUNT] += 1.0


@compiled(numba.void(_VECTOR, _VECTOR, _ROWS, _ROWS, _ROWS, _ROWS, _ROWS, _VECTOR, _ROWS, _ROWS, _VECTOR, numba.float64))
def _keep_apart(
    avoidance: Array,
    formation: Array,
    bodies: Array,
    positions: Array,
    velocities: Array,
    wanted: Array,
    told: Array,
    pair_gains: Array,
    emergencies: Array,
    pushes: Array,
    measures: Array,
    dt_s: float,
) -> None:
    """pushes (n, 7): acceleration away from bodies (3), velocity away from teammates (3), whether it is an emergency."""
    apart, push = np.zeros(3), np.zeros(3)
    limit = avoidance[PUSH_MAX]
    share = 1.0 - math.exp(-dt_s / formation[SMOOTHING])
    for i in range(positions.shape[0]):
        nearest = repel(formation, positions, pair_gains, i, apart)
        limited = told[i, 0] ** 2 + told[i, 1] ** 2 + told[i, 2] ** 2 > LIMITED_FROM * limit * limit
        pair_gains[i] = adapted_gain(formation, pair_gains[i], nearest, 0.0 if limited else dt_s)
        measures[GAIN_MAX] = max(measures[GAIN_MAX], pair_gains[i])
        push_away(avoidance, bodies, positions[i], velocities[i], push)
        error = 0.0
        for k in range(3):
            error += (positions[i, k] - wanted[i, k]) ** 2
            pushes[i, 3 + k] += share * (apart[k] - pushes[i, 3 + k])
            pushes[i, k] = push[k]
        pushes[i, 6] = 0.0
        if flee(avoidance, bodies, emergencies[i], positions[i], velocities[i], math.sqrt(error), dt_s, push):
            pushes[i, 6] = 1.0
            for k in range(3):
                pushes[i, k] = push[k]


@compiled(numba.void(_VECTOR, _VECTOR, _VECTOR, _VECTOR, _LAYERS, _ROWS, _ROWS, _VECTOR, numba.int64, _VECTOR, _ROWS))
def fly_formation(
    plant: Array,
    gains: Array,
    avoidance: Array,
    formation: Array,
    references: Array,
    bodies: Array,
    starts: Array,
    air: Array,
    steps: int,
    measures: Array,
    trace: Array,
) -> None:
    """`steps` of STEP_S from standing at starts (n, 3) along references (n, m, 9).

    measures (MEASURES,) and trace (k, PLACES_FROM + 3 n), a row every steps // k, are written. Vehicle 0 leads. air: as
    `sim.wind.drawn`.
    """
    n = starts.shape[0]
    positions, velocities = starts.copy(), np.zeros((n, 3))
    told, flown, wanted = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((n, 9))
    wire = np.zeros((DELAY_STEPS_MAX, n, 3))
    states, emergencies = np.zeros((n, STATE_SIZE)), np.zeros((n, EMERGENCY_SIZE))
    pair_gains, pushes = np.ones(n), np.zeros((n, 7))
    reference, push, moved = np.zeros(9), np.zeros(3), np.zeros(3)
    period, delay, lag_s = int(plant[PERIOD_STEPS]), int(plant[DELAY_STEPS]), plant[LAG_S]
    kind, limit = int(plant[KIND]), plant[ACCELERATION_MAX]
    blend = 1.0 if lag_s <= 0.0 else 1.0 - math.exp(-STEP_S / lag_s)
    dt_s = period * STEP_S
    every = max(1, steps // max(1, trace.shape[0]))
    measures[:] = 0.0
    measures[CLEARANCE] = measures[PAIR_MIN] = measures[PAIR_MEAN_MIN] = math.inf
    for step in range(steps):
        t_s = step * STEP_S
        if step % period == 0:
            for i in range(n):
                reference_at(references, i, t_s, plant[REFERENCE_S], wanted[i])
        if plant[AVOIDS] > 0.0 and step % AVOID_STEPS == 0:
            _keep_apart(
                avoidance,
                formation,
                bodies,
                positions,
                velocities,
                wanted,
                told,
                pair_gains,
                emergencies,
                pushes,
                measures,
                AVOID_STEPS * STEP_S,
            )
        if step % period == 0:
            for i in range(n):
                error = 0.0
                for k in range(9):
                    reference[k] = wanted[i, k]
                for k in range(3):
                    reference[3 + k] += pushes[i, 3 + k]
                    push[k] = pushes[i, k]
                    if kind == PRINTED and pushes[i, 6] == 0.0:
                        push[k] += pushes[i, 3 + k]
                    error += (positions[i, k] - wanted[i, k]) ** 2
                error = math.sqrt(error)
                if kind == LAW:
                    observe(states[i], gains, dt_s if step > 0 else STEP_S, positions[i], velocities[i])
                    decide(states[i], gains, reference, push, told[i])
                elif kind == PRINTED:
                    decide_printed(states[i], gains, dt_s, positions[i], velocities[i], reference, push, told[i])
                else:
                    decide_cascade(states[i], gains, dt_s, positions[i], velocities[i], reference, push, told[i])
                squared = told[i, 0] ** 2 + told[i, 1] ** 2 + told[i, 2] ** 2
                measures[LIMITED] += 1.0 if squared > LIMITED_FROM * limit * limit else 0.0
                measures[ERROR] += error
                measures[ERROR_SQUARED] += error * error
                measures[ERROR_MAX] = max(measures[ERROR_MAX], error)
                measures[COUNT] += 1.0
                if t_s >= plant[SETTLED_S]:
                    measures[STEADY] += error
                    measures[STEADY_COUNT] += 1.0
        if step % CHECK_STEPS == 0:
            _measure_formation(measures, positions, bodies, wanted)
        if step % every == 0 and step // every < trace.shape[0]:
            row = step // every
            trace[row, 0] = t_s
            for k in range(3):
                trace[row, 1 + k], trace[row, 4 + k], trace[row, 7 + k] = wanted[0, k], positions[0, k], velocities[0, k]
                trace[row, 10 + k] = positions[0, k] - wanted[0, k]
                trace[row, 13 + k] = velocities[0, k] - wanted[0, 3 + k]
                trace[row, 16 + k] = told[0, k]
                trace[row, 19 + k] = states[0, DISTURBANCE + k] if kind == LAW else 0.0
                trace[row, 22 + k] = measures[PAIR_NOW + k]
            for i in range(n):
                for k in range(3):
                    trace[row, PLACES_FROM + 3 * i + k] = positions[i, k]
        for k in range(3):
            moved[k] = air_velocity(air, k, t_s, 0.0)
        for i in range(n):
            blown = plant[DRAG] * height_factor(air, -positions[i, 2])
            for k in range(3):
                wire[step % DELAY_STEPS_MAX, i, k] = told[i, k]
                arrived = wire[(step - delay) % DELAY_STEPS_MAX, i, k]
                flown[i, k] += blend * (arrived - flown[i, k])
                pushed = flown[i, k] + blown * moved[k]
                positions[i, k] += STEP_S * velocities[i, k] + 0.5 * STEP_S * STEP_S * pushed
                velocities[i, k] += STEP_S * pushed
    for i in range(n):
        measures[EMERGENCIES] += emergencies[i, EMERGENCY_SIZE - 1]
    squared = 0.0
    for k in range(3):
        squared += (positions[0, k] - references[0, references.shape[1] - 1, k]) ** 2
    measures[MISSED_GOAL] = math.sqrt(squared)
    measures[CLEARANCE] -= avoidance[HULL]

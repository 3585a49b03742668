"""The adaptive potential field: the force of a hundred bodies alone, and a decision from an observation."""

from __future__ import annotations

import numpy as np

from flightapp.bench.measurement import Measurement, Work, measure
from flightapp.bench.situation import DISCS, far
from flightapp.core.types import Array, Limits
from flightapp.planning.adaptive_apf.field import FIELD_SIZE, TRACK_COLUMNS, sum_forces
from flightapp.planning.adaptive_apf.parameters import AdaptiveApfParameters
from flightapp.planning.registry import make_planner
from flightapp.space.bodies import LENGTH
from flightapp.space.distance import all_gaps
from flightapp.space.random_scene import random_scene
from flightapp.space.shapes import Shape, bodies_of

BODIES = 100
FORCE_AIM_MS = 0.02
SEED = 11


def adaptive_apf_measurements(limits: Limits, seconds: float) -> list[Measurement]:
    """Both; `seconds` for both. Every body counts in the force: none is left out for its distance."""
    shapes: list[Shape] = []
    for seed in range(SEED, SEED + 10):
        shapes.extend(random_scene(seed, obstacles=17).shapes)
    bodies = bodies_of(shapes[:BODIES])
    gains = AdaptiveApfParameters(reach_max_m=500.0, modules="ABC", reach_m=500.0).gains(limits)
    which, gaps = np.arange(BODIES), np.zeros((BODIES, 4))
    tracks, out = np.zeros((BODIES, TRACK_COLUMNS)), np.zeros(FIELD_SIZE)
    start, goal, velocity = np.zeros(3), np.array((100.0, 100.0, -30.0)), np.array((3.0, 2.0, 0.0))

    def act(place: Array) -> None:
        all_gaps(bodies, place[0], place[1], place[2], 0.0, gaps)
        sum_forces(bodies, which, gaps, BODIES, place, velocity, start, goal, tracks, gains, 0.0, 0.1, out)

    planner = make_planner("adaptive-apf", limits=limits, parameters={"vehicle_radius_max_m": 0.0})
    if len(bodies) != BODIES or not bodies[:, LENGTH].all():
        raise RuntimeError(f"{len(bodies)} bodies instead of {BODIES}: this would measure something else")
    return [
        measure(Work(f"adaptive-apf, distances to {len(bodies)} bodies and their force", _place, act, FORCE_AIM_MS), seconds / 2),
        measure(Work(f"adaptive-apf, decision, {DISCS} discs", far, planner.step), seconds / 2),
    ]


def _place(k: int) -> Array:
    return np.array(((7.0 * k) % 100.0, (13.0 * k) % 100.0, -((3.0 * k) % 60.0)))

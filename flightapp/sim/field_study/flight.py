"""One flight of one method through one scene."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flightapp.core.types import Array
from flightapp.planning.adaptive_apf.escape import PAST, TRAP_SIZE
from flightapp.planning.adaptive_apf.field import FIELD_SIZE, TRACK_COLUMNS
from flightapp.planning.adaptive_apf.gains import Gains
from flightapp.planning.adaptive_apf.paper_step import ARRIVED, COLLIDED, STEP_S, fly_steps
from flightapp.sim.field_study.methods import Method
from flightapp.sim.field_study.scenes import PERIOD, FieldScene

TOLERANCE_M = 0.05
DRAWS = 16
OUTCOMES = ("arrived", "collided", "did not arrive")


@dataclass(frozen=True, slots=True)
class FieldFlight:
    """places_ned_m (steps + 1, 3); gaps_m (steps,): to the nearest surface after each step."""

    outcome: str
    steps: int
    escapes: int
    places_ned_m: Array
    gaps_m: Array
    goal_gap_m: float
    """How near it came to the goal."""

    @property
    def arrived(self) -> bool:
        return self.outcome == OUTCOMES[ARRIVED]

    @property
    def length_m(self) -> float:
        return float(np.linalg.norm(np.diff(self.places_ned_m, axis=0), axis=1).sum())

    @property
    def clearance_m(self) -> float:
        return float(self.gaps_m.min(initial=np.inf))

    @property
    def turn_max_rad(self) -> float:
        """The greatest turn from a step to the next."""
        moves = np.diff(self.places_ned_m, axis=0)
        lengths = np.linalg.norm(moves, axis=1)
        moves = moves[lengths > 1e-9] / lengths[lengths > 1e-9][:, None]
        cosines = np.clip((moves[1:] * moves[:-1]).sum(axis=1), -1.0, 1.0)
        return float(np.arccos(cosines).max(initial=0.0))

    @property
    def turn_max_deg_s(self) -> float:
        """The same as a rate; its unit follows from the step's STEP_S."""
        return float(np.degrees(self.turn_max_rad)) / STEP_S


def fly_scene(
    scene: FieldScene, method: Method, gains: Gains, step_m: float, steps: int, seed: int, inertia_1_s: float = 0.0
) -> FieldFlight:
    """`steps` at most; the seed is that of the random pushes; inertia_1_s: see `fly_steps`."""
    bodies = scene.bodies.copy()
    count = len(bodies)
    path, which = np.zeros((steps + 1, 4)), np.zeros(count, dtype=np.int64)
    draws = np.random.default_rng(seed).normal(size=(DRAWS, 3))
    outcome, flown, escapes = fly_steps(
        bodies, scene.phases.copy(), PERIOD, scene.start_ned_m, scene.goal_ned_m, gains, step_m, TOLERANCE_M,
        "B" in method.modules, inertia_1_s, draws, path, which, np.zeros((count, 4)), np.zeros((count, TRACK_COLUMNS)),
        np.zeros(TRAP_SIZE), np.zeros((PAST, 3)), np.zeros(FIELD_SIZE),
    )  # fmt: skip
    places = path[: flown + 1, :3]
    gap_m = float(np.linalg.norm(places - scene.goal_ned_m, axis=1).min())
    return FieldFlight(OUTCOMES[outcome], flown, escapes, places, path[1 : flown + 1, 3], gap_m)


def collided(flight: FieldFlight) -> bool:
    return flight.outcome == OUTCOMES[COLLIDED]

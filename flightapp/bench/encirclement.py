"""The cells of `oa-ecbvc`, and a whole decision, for one of ten pursuers among forty obstacles."""

from __future__ import annotations

import math

import numpy as np

from flightapp.bench.measurement import Measurement, Work, measure
from flightapp.bench.situation import BOUNDARY, DISCS, PERIOD_S
from flightapp.core.types import Array, Limits, Observation, ObstacleSet, TargetTrack, TeamMember, VehicleState
from flightapp.planning.encirclement.cells import cells
from flightapp.planning.geometry.half_planes import PLANE_COLUMNS, ROUND_COLUMNS, add_rounds
from flightapp.planning.registry import make_planner

PURSUERS = 10
CELLS_AIM_MS = 0.3
HALF_M = 15.0
"""Of the field in which everything stands, and of the box around the evader."""
NOTHING_UNSEEN = np.zeros((0, 2))


def encirclement_measurements(limits: Limits, seconds: float) -> list[Measurement]:
    """Half-planes and both cells of one pursuer; a decision from an observation; `seconds` for both."""
    planes = np.zeros((PURSUERS + DISCS, PLANE_COLUMNS))
    rooms = [np.zeros((PURSUERS + DISCS + 9, 2)) for _ in range(3)]
    planner = make_planner("oa-ecbvc", limits=limits, parameters={"vehicle_radius_max_m": 0.0})

    def cut(given: tuple[Array, Array]) -> None:
        rounds, own = given
        count = add_rounds(own[0], own[1], rounds, len(rounds), planes, 0)
        cells(own[0], own[1], 0.0, 0.0, HALF_M, HALF_M, planes, count, *rooms)

    about = f"{PURSUERS} pursuers, {DISCS} discs"
    return [
        measure(Work(f"oa-ecbvc, cells of one, {about}", _rounds, cut, CELLS_AIM_MS), seconds / 2),
        measure(
            Work(f"oa-ecbvc, decision of one, {about}", _observation, lambda seen: _decide(planner.step(seen).mode)), seconds / 2
        ),
    ]


def _decide(mode: str) -> None:
    if mode == "hold":
        raise RuntimeError("the planner holds: this would measure something else")


def _places(k: int) -> tuple[Array, Array]:
    """Pursuers (10, 2) and discs (40, 3), others in every period; no pursuer in a disc."""
    random = np.random.default_rng(k)
    bearings = random.uniform(-math.pi, math.pi, DISCS)
    distances = random.uniform(3.0, HALF_M, DISCS)
    discs = np.column_stack((distances * np.cos(bearings), distances * np.sin(bearings), random.uniform(0.3, 0.8, DISCS)))
    pursuers: list[Array] = []
    while len(pursuers) < PURSUERS:
        place = random.uniform(-HALF_M, HALF_M, 2)
        if (np.hypot(discs[:, 0] - place[0], discs[:, 1] - place[1]) > discs[:, 2] + 0.9).all():
            pursuers.append(place)
    return np.array(pursuers), discs


def _rounds(k: int) -> tuple[Array, Array]:
    pursuers, discs = _places(k)
    rows = np.zeros((PURSUERS - 1 + DISCS, ROUND_COLUMNS))
    rows[: PURSUERS - 1, :2], rows[: PURSUERS - 1, 2:4] = pursuers[1:], (0.3, 0.5)
    rows[PURSUERS - 1 :, :3], rows[PURSUERS - 1 :, 3] = discs, 1.0
    return rows, pursuers[0]


def _observation(k: int) -> Observation:
    pursuers, discs = _places(k)
    t_s = k * PERIOD_S
    states = [VehicleState(t_s, np.array((*place, -5.0)), np.zeros(3), 0.0) for place in pursuers]
    team = tuple(TeamMember(f"p{i}", state, "encircle", None, 0.04) for i, state in enumerate(states[1:], 2))
    rows = np.zeros((DISCS, 7))
    rows[:, :3], rows[:, 5], rows[:, 6] = discs, -np.inf, np.inf
    target = TargetTrack(t_s, np.array((0.0, 0.0, -5.0)), np.array((-1.0, 0.5, 0.0)), np.eye(6) * 0.01, 0.02)
    return Observation(t_s, PERIOD_S, states[0], team, target, ObstacleSet(t_s, rows, NOTHING_UNSEEN), BOUNDARY)

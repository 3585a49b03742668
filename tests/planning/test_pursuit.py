"""A pursuer's intent: as in plain Python, and each of the ways to pursue."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from flightapp.core.types import Array, Limits
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.pursuit import intend
from flightapp.planning.ac2f.records import INTENT, MEMORY, VIEW, parameter_record
from flightapp.planning.ac2f.stage import Stage
from flightapp.planning.plane import Point, Segment
from tests.planning import pursuit_reference as reference

LIMITS = Limits(6.0, 6.0, 40.0, 3.0, 12.0, 2.0, 0.35, 0.45)
LINE: tuple[Segment, ...] = (((0.0, -200.0), (0.0, 200.0)),)
RING = {"radius_m": 3.0, "hold_radius_m": 2.2}
CONTACT = {"mode": "first"}

coordinate = st.floats(-40.0, 40.0).map(lambda value: round(value, 3))
place = st.tuples(coordinate, coordinate)
speed = st.floats(-5.0, 5.0)
velocity = st.tuples(speed, speed)
disc = st.tuples(coordinate, coordinate, st.floats(0.3, 4.0))
vehicle_limits = st.builds(
    lambda top, acceleration: Limits(top, acceleration, 40.0, 3.0, 12.0, 2.0, 0.35, 0.45),
    st.floats(3.0, 9.0),
    st.floats(2.0, 8.0),
)


def wanted(
    parameters: Ac2fParameters,
    own: Point,
    evader: Point,
    evader_velocity: Point = (0.0, 0.0),
    *,
    team: tuple[Point, ...] = (),
    etas: tuple[float, ...] = (),
    discs: tuple[tuple[float, float, float], ...] = (),
    sides: tuple[Segment, ...] = LINE,
    closed: bool = False,
    lost: bool = False,
    stage: Stage = Stage.COARSE,
    limits: Limits = LIMITS,
) -> tuple[Any, Array]:
    """The intent and the goals of the game; the arrays are longer than needed, as in flight."""
    view, memory, intent = np.zeros(1, VIEW), np.zeros(1, MEMORY), np.zeros(1, INTENT)
    memory["stage"], memory["boundary_lost"] = list(Stage).index(stage), lost
    view["own_n"], view["own_e"] = own
    view["target_n"], view["target_e"] = evader
    view["target_vn"], view["target_ve"] = evader_velocity
    view["distance_m"] = math.dist(own, evader)
    view["team_count"], view["obstacle_count"] = len(team), len(discs)
    rows = np.full((len(team) + 2, 4), 1e3)
    rows[: len(team), :2] = np.array(team).reshape(-1, 2)
    scene = np.full((len(discs) + 2, 6), 1.0)
    scene[: len(discs), :3] = np.array(discs).reshape(-1, 3)
    count = len(rows) + 1
    goals = np.full((count, 2), math.nan)
    intend(
        parameter_record(parameters, limits),
        memory,
        view,
        rows,
        np.array((*etas, math.nan)),
        scene,
        np.array(sides, dtype=np.float64).reshape(-1, 4),
        closed,
        np.empty((count, 2)),
        np.empty((count, 6)),
        np.empty(count),
        goals,
        intent,
    )
    return intent[0], goals[: len(team) + 1]


def goal_of(intent: Any) -> Point:
    return float(intent["goal_n"]), float(intent["goal_e"])


def velocity_of(intent: Any) -> Point:
    return float(intent["velocity_n"]), float(intent["velocity_e"])


@given(
    own=place,
    team=st.lists(place, max_size=3, unique=True),
    etas=st.lists(st.floats(0.0, 30.0), max_size=3),
    evader=place,
    evader_velocity=velocity,
    discs=st.lists(disc, max_size=6),
    corners=st.lists(place, min_size=2, max_size=4),
    closed=st.booleans(),
    lost=st.booleans(),
    limits=vehicle_limits,
    rule=st.sampled_from([RING, {}]),
)
def test_the_kernel_agrees_with_plain_python(
    own: Point,
    team: list[Point],
    etas: list[float],
    evader: Point,
    evader_velocity: Point,
    discs: list[tuple[float, float, float]],
    corners: list[Point],
    closed: bool,
    lost: bool,
    limits: Limits,
    rule: dict[str, object],
) -> None:
    assume(own not in team and evader not in team)
    parameters = Ac2fParameters.model_validate({"capture": rule})
    sides = tuple(itertools.pairwise([*corners, corners[0]] if closed else corners))
    scene = np.array(discs).reshape(-1, 3)
    python = reference.Pursuit(parameters, limits)
    target = reference.Target(evader, evader_velocity)
    expected = python.intent(own, team, etas, target, scene, sides, closed=closed, boundary_lost=lost)
    found, goals = wanted(
        parameters,
        own,
        evader,
        evader_velocity,
        team=tuple(team),
        etas=tuple(etas),
        discs=tuple(discs),
        sides=sides,
        closed=closed,
        lost=lost,
        limits=limits,
    )
    assert found["contested"] == (expected.game.contested and not lost)
    assert found["boundary_m"] == pytest.approx(expected.game.distance_m, abs=1e-6)
    assert found["eta_s"] == pytest.approx(expected.eta_s, abs=1e-6)
    if math.dist(goals[0], expected.game.goals[0]) < 1e-6:  # where two points are equally good, either may be taken
        assert goal_of(found) == pytest.approx(expected.goal, abs=1e-6)
        assert velocity_of(found) == pytest.approx(expected.velocity, abs=1e-5)

"""Random but possible situations: what a planner may be given on a bad day, with everything finite and of a plausible size.

The shape of a situation is drawn by hypothesis, so that a failing one gets small; the many numbers in it come from a seed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from hypothesis import strategies as st

from flightapp.core.types import (
    Array,
    Assignment,
    Boundary,
    Observation,
    ObstacleSet,
    TargetTrack,
    TeamMember,
    VehicleState,
)

EXTENT_M = 60.0
START_S = (0.0, 1000.0, 1_750_000_000.0)
UNSEEN = {
    "nothing": np.zeros((0, 2)),
    "everything": np.array([[-math.pi, math.pi]]),
    "behind": np.array([[-math.pi, -0.76], [0.76, math.pi]]),
    "slits": np.array([[a, a + 1e-6] for a in np.linspace(-3.0, 3.0, 12)]),
}


@dataclass(frozen=True, slots=True)
class Shape:
    """What hypothesis chooses; `scale_m` is how close everything is to the own place."""

    seed: int
    start_s: float
    scale_m: float
    discs: int
    touching: bool
    """The first disc has its edge on the own position, the second is around it."""
    unseen: str
    obstacles_age_s: float
    teammates: int
    coincident: bool
    """Teammates and target stand exactly where the vehicle does."""
    team_age_s: float
    target: str
    """none, fresh, old, vague."""
    boundary: str
    """line, polygon, short, far."""
    assigned: bool
    dt_s: float
    steps: int
    speed_m_s: float


shapes = st.builds(
    Shape,
    seed=st.integers(0, 2**32 - 1),
    start_s=st.sampled_from(START_S),
    scale_m=st.sampled_from((0.0, 1e-9, 1.0, 10.0, EXTENT_M)),
    discs=st.sampled_from((0, 1, 2, 7, 40, 200)),
    touching=st.booleans(),
    unseen=st.sampled_from(tuple(UNSEEN)),
    obstacles_age_s=st.sampled_from((0.0, 0.05, 2.0, 1e4)),
    teammates=st.integers(0, 7),
    coincident=st.booleans(),
    team_age_s=st.sampled_from((0.0, 0.05, 0.9, 9.0)),
    target=st.sampled_from(("none", "fresh", "old", "vague")),
    boundary=st.sampled_from(("line", "polygon", "short", "far")),
    assigned=st.booleans(),
    dt_s=st.sampled_from((0.0, 1e-6, 0.033, 0.05, 1.5)),
    steps=st.integers(1, 6),
    speed_m_s=st.sampled_from((0.0, 1e-12, 3.0, 12.0)),
)


def situation(shape: Shape) -> list[Observation]:
    """A few control periods in a row; the vehicle's own motion goes on from each to the next."""
    random = np.random.default_rng(shape.seed)
    boundary = _boundary(shape, random)
    place, velocity = random.uniform(-EXTENT_M, EXTENT_M, 3), _speed(random, shape.speed_m_s)
    seen = []
    for step in range(shape.steps):
        t_s = shape.start_s + step * shape.dt_s
        own = VehicleState(t_s, place.copy(), velocity.copy(), float(random.uniform(-math.pi, math.pi)))
        seen.append(
            Observation(
                t_s=t_s,
                dt_s=shape.dt_s if step else 0.0,
                own=own,
                team=_team(shape, own, random),
                target=_target(shape, own, random),
                obstacles=ObstacleSet(t_s - shape.obstacles_age_s, _discs(shape, place, random), UNSEEN[shape.unseen]),
                boundary=boundary,
                assignment=Assignment(float(random.uniform(-math.pi, math.pi)), t_s + float(random.uniform(-2.0, 20.0)))
                if shape.assigned
                else None,
            )
        )
        place = place + velocity * shape.dt_s
        velocity = velocity + random.normal(0.0, 0.1, 3) * (shape.speed_m_s > 0.0)
    return seen


def _speed(random: np.random.Generator, speed_m_s: float) -> Array:
    bearing = random.uniform(-math.pi, math.pi)
    return speed_m_s * np.array([math.cos(bearing), math.sin(bearing), 0.1])


def _around(place: Array, scale_m: float, random: np.random.Generator) -> Array:
    return place + scale_m * random.uniform(-1.0, 1.0, 3)


def _discs(shape: Shape, place: Array, random: np.random.Generator) -> Array:
    discs = np.zeros((shape.discs, 7))
    discs[:, :2] = place[:2] + max(shape.scale_m, 1.0) * random.uniform(-1.0, 1.0, (shape.discs, 2))
    discs[:, 2] = random.choice((0.01, 0.3, 1.0, 8.0), shape.discs)
    discs[:, 3:5] = random.choice((0.0, 0.0, 3.0, -6.0), (shape.discs, 2))
    discs[:, 5], discs[:, 6] = -math.inf, math.inf
    if shape.touching:
        discs[:1, :3] = place[0] + 1.0, place[1], 1.0
        discs[1:2, :3] = place[0], place[1], 0.5
    return discs


def _team(shape: Shape, own: VehicleState, random: np.random.Generator) -> tuple[TeamMember, ...]:
    members = []
    for number in range(shape.teammates):
        place = own.position_ned_m.copy() if shape.coincident else _around(own.position_ned_m, shape.scale_m, random)
        eta_s = None if number % 2 else float(random.uniform(0.0, 30.0))
        state = VehicleState(own.t_s, place, _speed(random, shape.speed_m_s), 0.0)
        members.append(TeamMember(f"p{number + 2}", state, "coarse", eta_s, shape.team_age_s))
    return tuple(members)


def _target(shape: Shape, own: VehicleState, random: np.random.Generator) -> TargetTrack | None:
    if shape.target == "none":
        return None
    place = own.position_ned_m.copy() if shape.coincident else _around(own.position_ned_m, shape.scale_m, random)
    age_s = 600.0 if shape.target == "old" else 0.02
    covariance = np.eye(6) * (1e8 if shape.target == "vague" else 0.01)
    return TargetTrack(own.t_s, place, _speed(random, shape.speed_m_s), covariance, age_s)


def _boundary(shape: Shape, random: np.random.Generator) -> Boundary:
    if shape.boundary == "polygon":
        return Boundary(
            np.array([[-EXTENT_M, -EXTENT_M], [EXTENT_M, -EXTENT_M], [EXTENT_M, EXTENT_M], [-EXTENT_M, EXTENT_M]]), True
        )
    ends = {"line": ((0.0, -30.0), (0.0, 30.0)), "short": ((0.0, 0.0), (0.0, 1e-3)), "far": ((-5e4, 0.0), (-5e4, 1.0))}
    return Boundary(np.array(ends[shape.boundary]), False)

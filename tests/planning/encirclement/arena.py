"""A team of velocity-controlled points around one evader: the closed loop in which the paper's claims are tested.

Everybody decides from exact positions at the same time (or from old ones), then all fly straight for one period; distances are
checked along the way, not only at its ends.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from flightapp.core.clearance import way_gap_m
from flightapp.core.types import (
    Array,
    Boundary,
    Decision,
    Limits,
    Observation,
    ObstacleSet,
    TargetTrack,
    TeamMember,
    VehicleState,
)
from flightapp.planning.api import Planner
from flightapp.planning.capture import widest_gap_rad
from flightapp.planning.plane import Point
from flightapp.planning.registry import make_planner

PERIOD_S = 0.1
RADIUS_M = 0.15
CAPTURE = {"radius_m": 1.0, "mode": "first"}
FAR = Boundary(np.array([[-1000.0, -1000.0], [-1000.0, 1000.0]]), False)
LIMITS = Limits(1.0, 1000.0, 1e6, 100.0, 1e4, 2.0, RADIUS_M, 0.0)
GIVEN = {"vehicle": "single-integrator", "capture": CAPTURE, "evader_speed_assumed_m_s": 0.9, "vehicle_radius_max_m": 0.0}

Evading = Callable[[float, Array, Array], Array]
"""(t_s, own place, pursuers (k, 2)) -> velocity (m/s)."""


def standing(t_s: float, own: Array, pursuers: Array) -> Array:
    return np.zeros(2)


def fleeing(speed_m_s: float = 0.9) -> Evading:
    """From the nearest."""

    def flee(t_s: float, own: Array, pursuers: Array) -> Array:
        away = own - pursuers[np.hypot(*(pursuers - own).T).argmin()]
        return speed_m_s * away / max(float(np.hypot(*away)), 1e-9)

    return flee


@dataclass
class Chase:
    """What happened."""

    captured_s: float | None = None
    encircled_s: float | None = None
    clearance_m: float = math.inf
    """Least distance of a pursuer's centre to an obstacle's surface."""
    separation_m: float = math.inf
    """Least distance of two pursuers' centres."""
    places: list[Array] = field(default_factory=list)
    """(k + 1, 2) a period, the evader last."""
    decisions: list[list[Decision]] = field(default_factory=list)


def member(
    name: str, t_s: float, place: Point | Array, velocity: Point = (0.0, 0.0), mode: str = "", age_s: float = 0.0
) -> TeamMember:
    state = VehicleState(t_s, np.array((*place, -5.0)), np.array((*velocity, 0.0)), 0.0)
    return TeamMember(name, state, mode, None, age_s)


def observation(
    own: Point | Array,
    team: Sequence[Point | Array | TeamMember] = (),
    evader: Point | Array | None = None,
    discs: Sequence[Sequence[float]] = (),
    *,
    t_s: float = 0.0,
    velocity: Point = (0.0, 0.0),
    yaw_rad: float = 0.0,
    evader_velocity: Point = (0.0, 0.0),
    evader_age_s: float = 0.0,
    period_s: float = PERIOD_S,
) -> Observation:
    """What the pursuer at `own` knows; discs: (north, east, radius[, v_north, v_east])."""
    members = tuple(one if isinstance(one, TeamMember) else member(f"p{k + 2}", t_s, one) for k, one in enumerate(team))
    rows = np.zeros((len(discs), 7))
    rows[:, 5], rows[:, 6] = -np.inf, np.inf
    for row, disc in zip(rows, discs, strict=True):
        row[: len(disc)] = disc
    track = None
    if evader is not None:
        track = TargetTrack(t_s, np.array((*evader, -5.0)), np.array((*evader_velocity, 0.0)), np.eye(6), evader_age_s)
    state = VehicleState(t_s, np.array((*own, -5.0)), np.array((*velocity, 0.0)), yaw_rad)
    return Observation(t_s, period_s, state, members, track, ObstacleSet(t_s, rows, np.zeros((0, 2))), FAR)


def pursuer(name: str = "oa-ecbvc", limits: Limits = LIMITS, **parameters: object) -> Planner:
    return make_planner(name, limits=limits, parameters={**GIVEN, **parameters})


def chase(
    starts: Sequence[Point],
    evader: Point,
    discs: Sequence[Sequence[float]] = (),
    *,
    evading: Evading = standing,
    method: str = "oa-ecbvc",
    seconds: float = 60.0,
    delay_periods: int = 0,
    stops: bool = True,
    **parameters: object,
) -> Chase:
    """Fly until the evader is captured, at most `seconds`; mates are seen as they were `delay_periods` ago."""
    team = [pursuer(method, **parameters) for _ in starts]
    places = np.array([*starts, evader], dtype=np.float64)
    past, modes, found = [places.copy()], [""] * len(team), Chase()
    for tick in range(round(seconds / PERIOD_S)):
        t_s = tick * PERIOD_S
        found.places.append(places.copy())
        gaps = np.arctan2(*(places[:-1] - places[-1]).T[::-1]).copy()
        if found.encircled_s is None and len(team) > 2 and widest_gap_rad(gaps) < math.pi:
            found.encircled_s = t_s
        if np.hypot(*(places[:-1] - places[-1]).T).min() <= 1.0 and found.captured_s is None:
            found.captured_s = t_s
            if stops:
                return found
        heard = past[max(0, len(past) - 1 - delay_periods)]
        age_s = min(delay_periods, len(past) - 1) * PERIOD_S
        decisions = []
        for i, planner in enumerate(team):
            mates = [member(f"p{j}", t_s - age_s, heard[j], mode=modes[j], age_s=age_s) for j in range(len(team)) if j != i]
            decisions.append(planner.step(observation(places[i], mates, places[-1], discs, t_s=t_s)))
        modes = [decision.mode for decision in decisions]
        found.decisions.append(decisions)
        after = places.copy()
        for i, decision in enumerate(decisions):
            after[i] += PERIOD_S * decision.velocity_ned_m_s[:2]
        after[-1] += PERIOD_S * evading(t_s, places[-1], places[:-1])
        _check(found, places[:-1], after[:-1], discs)
        places = after
        past.append(places.copy())
    return found


def _check(found: Chase, before: Array, after: Array, discs: Sequence[Sequence[float]]) -> None:
    way = after - before
    for i in range(len(before)):
        for n, e, radius, *_ in discs:
            found.clearance_m = min(found.clearance_m, way_gap_m(*(before[i] - (n, e)), *way[i], radius))
        for j in range(i):
            found.separation_m = min(found.separation_m, way_gap_m(*(before[i] - before[j]), *(way[i] - way[j]), 0.0))

"""The kernels that digest one observation, against plain Python."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.types import Array
from flightapp.planning.ac2f.history import sample_position, variance_m2
from flightapp.planning.ac2f.judge import judge
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.recollection import blank_recollection
from flightapp.planning.ac2f.records import VIEW, blank_memory, parameter_record
from flightapp.planning.ac2f.scene import inflate
from flightapp.planning.ac2f.surroundings import follow_others, look
from flightapp.planning.boundary import is_crossed
from flightapp.planning.capture import CaptureRule
from flightapp.planning.plane import Point, crosses
from tests.planning.capture_reference import encircled
from tests.planning.closed_loop import limits

PLACE = st.tuples(st.floats(-20, 20), st.floats(-20, 20))
SEEDS = st.integers(0, 10_000)
RULE = CaptureRule(radius_m=3.0, hold_radius_m=2.2)
PARAMETERS = Ac2fParameters(capture=RULE)


class Looker:
    """`look` and `judge` with the arrays that they need."""

    def __init__(self, parameters: Ac2fParameters = PARAMETERS) -> None:
        self.parameters = parameter_record(parameters, limits())
        self.memory, self.view = blank_memory(), np.zeros(1, VIEW)
        self.scene, self.trail = np.zeros((80, 6)), np.zeros((200, 3))
        self.history = np.zeros((30, 2))
        self.recollection = blank_recollection()

    def look(
        self, own: Array, velocity: Array, members: Array, target: Array, age_s: float, discs: Array, t_s: float = 1.0
    ) -> tuple[Array, Array]:
        """Team and etas; target: (4,) north, east, velocities at 0.1 s before `t_s`; the discs are 0.05 s old."""
        team, etas = np.zeros((len(members), 4)), np.zeros(len(members))
        look(
            self.parameters, self.memory, own, velocity, 0.3, t_s, members, target[:2].copy(), target[2:].copy(), t_s - 0.1,
            age_s, discs, t_s - 0.05, np.zeros((0, 2)), team, etas, self.recollection, self.scene, self.trail, self.view,
        )  # fmt: skip
        return team, etas

    def judge(self, team: Array, sides: Array) -> int:
        return judge(self.parameters, self.memory, self.view, team, self.history, sides)


def plain_scene(discs: Array, own: Array, vehicles: list[tuple[Array, float]], places: list[Array]) -> list[list[float]]:
    """The rows that the scene should have: obstacles 0.05 s old, then vehicles (4,) with the distance to keep."""
    rows, keeps = [], []
    for disc in discs:
        place = disc[:2] + 0.05 * disc[3:5]
        is_vehicle = disc[2] <= 0.6 and any(math.dist(place, other) < disc[2] + 0.25 for other in places)
        if not is_vehicle:
            rows.append([*place, *disc[3:5]])
            keeps.append((disc[2], disc[2] + 0.8))
    for vehicle, keep in vehicles:
        rows.append([*vehicle])
        keeps.append((keep, keep))
    found = []
    for row, (reach, keep) in zip(rows, keeps, strict=True):
        distance = math.dist(row[:2], own)
        if distance - reach <= 15.0:
            found.append([row[0], row[1], max(0.0, min(keep, distance - 0.02)), row[2], row[3], max(0.0, keep - distance)])
    return found


@settings(max_examples=60, deadline=None)
@given(SEEDS)
def test_look_agrees_with_plain_python(seed: int) -> None:
    random = np.random.default_rng(seed)
    looker = Looker()
    own, velocity = random.uniform(-3, 3, 2), random.uniform(-3, 3, 2)
    age_s, eta_s = random.uniform(0.0, 4.0, 3), random.uniform(1.0, 9.0, 3)
    told_s = np.where(random.random(3) < 0.5, 1.0, 1.0 - age_s)  # moved to the present already, or as it was heard
    members = np.column_stack((random.uniform(-12, 12, (3, 4)), told_s, age_s, eta_s))
    target = random.uniform(-15, 15, 4)
    discs = np.column_stack((random.uniform(-20, 20, (30, 2)), random.uniform(0.1, 1.5, 30), random.uniform(-1, 1, (30, 4))))
    team, etas = looker.look(own, velocity, members, target, 0.2, discs)
    order = [*np.flatnonzero(age_s <= 2.0), *np.flatnonzero(age_s > 2.0)]
    fresh = int((age_s <= 2.0).sum())
    expected = members[order][:, :4].copy()
    expected[:, :2] += expected[:, 2:] * np.minimum(1.0, 1.0 - members[order][:, 4:5])
    np.testing.assert_allclose(team, expected, atol=1e-12)
    np.testing.assert_array_equal(etas, eta_s[order])
    view = looker.view[0]
    evader = target.copy()
    evader[:2] += 0.1 * target[2:]
    separation = {1: 2.2, 2: 2.2, 3: 2.2, 4: 0.95 * 2.2 * math.sqrt(2.0)}[fresh + 1]
    vehicles = [(team[i], min(2.2, separation)) for i in range(fresh)] + [(evader, 1.5)]
    scene = plain_scene(discs, own, vehicles, [*team[:, :2], evader[:2]])
    np.testing.assert_allclose(looker.scene[: view["scene_count"]], np.array(scene).reshape(-1, 6), atol=1e-12)
    assert view["depth_m"] == pytest.approx(max([row[5] for row in scene], default=0.0))
    gaps = [math.dist(row[:2], own) - row[2] for row in scene]
    assert view["clearance_m"] == pytest.approx(min([15.0, *gaps]))
    assert (view["team_count"], view["team_complete"]) == (fresh, fresh == 3)
    assert view["distance_m"] == pytest.approx(math.dist(own, evader[:2]))


def test_without_a_target_nothing_is_known_of_it() -> None:
    looker = Looker()
    looker.look(np.zeros(3), np.zeros(3), np.zeros((0, 7)), np.zeros(4), math.nan, np.zeros((0, 7)))
    view = looker.view[0]
    assert (view["target_known"], view["scene_count"], view["distance_m"]) == (0, 0, math.inf)


@given(SEEDS)
def test_the_trail_keeps_two_seconds_and_never_outgrows_its_room(seed: int) -> None:
    random = np.random.default_rng(seed)
    looker = Looker()
    looker.trail = np.zeros((60, 3))
    team = np.zeros((2, 4))
    kept: list[tuple[float, float]] = []
    next_s = t_s = 0.0
    for step in range(200):
        t_s += random.uniform(0.01, 0.2)
        team[:, 0] = step
        looker.view["t_s"] = t_s
        known = follow_others(looker.parameters, looker.memory, looker.view, team, looker.trail)
        if t_s >= next_s - 1e-9:
            next_s = t_s + 0.1
            kept = [(since, place) for since, place in kept if t_s - since <= 2.0] + [(t_s, float(step))]
        expected = [place for _, place in [*kept, (t_s, float(step))] for _ in range(2)]
        assert looker.trail[:known, 0].tolist() == expected


@given(st.lists(PLACE, max_size=6), st.floats(0.1, 0.9))
def test_a_disc_where_a_vehicle_is_or_was_is_no_obstacle(trail: list[Point], radius: float) -> None:
    discs = np.array([[2.0, 1.0, radius, 0.0, 0.0, -np.inf, np.inf]])
    places = np.array(trail).reshape(-1, 2)
    count = inflate(discs, 0.0, 0.0, 0.0, 0.8, 15.0, places, 0.25, 0.6, np.zeros((1, 6)))
    is_vehicle = radius <= 0.6 and any(math.dist((2.0, 1.0), place) < radius + 0.25 for place in trail)
    assert count == (0 if is_vehicle else 1)


@given(st.lists(PLACE, min_size=2, max_size=5), PLACE, PLACE)
def test_crossing_agrees_with_the_plane(corners: list[Point], start: Point, end: Point) -> None:
    sides = list(itertools.pairwise(corners))
    assert is_crossed(np.array(sides).reshape(-1, 4), *start, *end) == crosses(start, end, sides)


@settings(max_examples=100, deadline=None)
@given(SEEDS, st.integers(0, 4))
def test_surrounded_is_what_the_capture_rule_says(seed: int, teammates: int) -> None:
    random = np.random.default_rng(seed)
    looker = Looker()
    members = np.zeros((teammates, 7))
    members[:, 4] = 1.0
    members[:, :2] = random.uniform(-3.0, 3.0, (teammates, 2))
    own = random.uniform(-3.0, 3.0, 2)
    team, _ = looker.look(own, np.zeros(2), members, np.zeros(4), 0.0, np.zeros((0, 7)))
    looker.judge(team, np.zeros((0, 4)))
    everyone: list[Point] = [(float(n), float(e)) for n, e in [own, *members[:, :2]]]
    assert looker.view[0]["surrounded"] == encircled((0.0, 0.0), everyone, RULE)


def test_capture_needs_the_dwell_without_a_break_and_stays() -> None:
    looker = Looker(Ac2fParameters(capture=CaptureRule(radius_m=3.0, dwell_s=0.5)))
    captured = []
    for tick, near in enumerate([1, 1, 1, 0, 1, 1, 1, 1, 1, 1, 0, 0]):
        own = np.array((1.0 if near else 9.0, 0.0))
        team, _ = looker.look(own, np.zeros(2), np.zeros((0, 7)), np.zeros(4), 0.0, np.zeros((0, 7)), 0.1 * tick)
        looker.judge(team, np.zeros((0, 4)))
        captured.append(int(looker.memory[0]["captured"]))
    assert captured == [0] * 9 + [1] * 3


def test_an_evader_that_crosses_has_won_for_good() -> None:
    looker = Looker()
    sides = np.array([[0.0, -50.0, 0.0, 50.0]])
    lost = []
    for tick, north in enumerate((2.0, 1.0, -0.5, 3.0)):
        target = np.array((north, 0.0, 0.0, 0.0))
        team, _ = looker.look(np.array((20.0, 0.0)), np.zeros(2), np.zeros((0, 7)), target, 0.0, np.zeros((0, 7)), 0.1 * tick)
        looker.judge(team, sides)
        lost.append(int(looker.memory[0]["boundary_lost"]))
    assert lost == [0, 0, 1, 1]


def test_history_keeps_its_own_rate() -> None:
    memory, history = blank_memory(), np.zeros((30, 2))
    for tick in range(300):
        sample_position(memory, tick / 100, 0.1, float(tick), 0.0, history)
    assert memory[0]["history_count"] == 30
    assert np.diff(history[:, 0]) == pytest.approx(np.full(29, 10.0))
    sample_position(memory, 10.0, 0.1, 5.0, 0.0, history)
    assert memory[0]["history_count"] == 1


@given(SEEDS, st.integers(1, 30))
def test_variance_is_the_trace_of_the_covariance(seed: int, count: int) -> None:
    points = np.random.default_rng(seed).uniform(-5.0, 5.0, (count, 2))
    assert variance_m2(points) == pytest.approx(points.var(axis=0).sum())

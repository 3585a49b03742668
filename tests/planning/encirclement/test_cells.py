"""Cells: disjoint by what vehicles need, convex, tiling, moved and turned with their world; velocities that stay in them."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.types import Array
from flightapp.planning.encirclement.cells import Cells, Dynamics, cells, held_velocity
from flightapp.planning.geometry.convex import nearest_in
from flightapp.planning.geometry.half_planes import add_rounds

FEW = settings(max_examples=30, deadline=None)
coordinate = st.floats(-10.0, 10.0).map(lambda value: round(value, 3))
place = st.tuples(coordinate, coordinate)
team = st.lists(place, min_size=2, max_size=6, unique=True)
discs = st.lists(st.tuples(coordinate, coordinate, st.floats(0.2, 1.5)), max_size=4)
RADIUS_M = 0.15
Places = list[tuple[float, float]]
Discs = list[tuple[float, float, float]]


class Cut:
    """Both cells of the first of `team`, as shapely sees them."""

    def __init__(
        self,
        own: tuple[float, float],
        mates: Places,
        evader: tuple[float, float],
        half: float | tuple[float, float],
        discs: Discs = (),
        radius: float = RADIUS_M,
    ) -> None:  # type: ignore[assignment]
        rounds = [(*mate, 2 * radius, 0.5, 0.0) for mate in mates] + [(n, e, r + radius, 1.0, 0.0) for n, e, r in discs]
        rows = np.array(rounds).reshape(-1, 5)
        self.planes = np.zeros((len(rows) + 1, 3))
        self.count = add_rounds(*own, rows, len(rows), self.planes, 0)
        rooms: list[Array] = [np.zeros((len(rows) + 9, 2)) for _ in range(3)]
        half_n, half_e = half if isinstance(half, tuple) else (half, half)
        self.found: Cells = cells(*own, *evader, half_n, half_e, self.planes, self.count, *rooms)
        self.safety = rooms[0][: int(self.found.safety_corners)]
        self.target = rooms[1][: int(self.found.target_corners)]

    @property
    def target_polygon(self) -> shapely.Polygon:
        return shapely.Polygon(self.target) if len(self.target) > 2 else shapely.Polygon()

    @property
    def safety_polygon(self) -> shapely.Polygon:
        return shapely.Polygon(self.safety) if len(self.safety) > 2 else shapely.Polygon()


def extent(places: Places, evader: tuple[float, float]) -> float:
    return max(max(abs(n - evader[0]), abs(e - evader[1])) for n, e in places) + 0.1


@FEW
@given(team, place, discs)
def test_cells_keep_vehicles_apart_and_off_obstacles(places: Places, evader: tuple[float, float], obstacles: Discs) -> None:
    half = extent(places, evader)
    cut = [Cut(own, [p for p in places if p != own], evader, half, obstacles) for own in places]
    for i, own in enumerate(places):
        room = min((math.dist(own, p) / 2 - RADIUS_M for p in places if p != own), default=math.inf)
        room = min([room, *(math.dist(own, (n, e)) - r - RADIUS_M for n, e, r in obstacles)])
        found = cut[i].safety_polygon
        inside = nearest_in(cut[i].safety, len(cut[i].safety), *own) == own if len(cut[i].safety) else False
        if abs(room) > 1e-9:
            assert inside == (room > 0.0)
        assert found.is_valid
        assert found.convex_hull.area == pytest.approx(found.area, abs=1e-6)
        assert cut[i].target_polygon.is_empty or found.buffer(1e-6).contains(cut[i].target_polygon)
        assert np.abs(cut[i].target - evader).max(initial=0.0) <= half + 1e-9, "the target cell is within the box"
        for n, e, radius in obstacles:
            assert found.is_empty or found.distance(shapely.Point(n, e)) >= radius + RADIUS_M - 1e-6
        for j in range(i):
            other = cut[j].safety_polygon
            assert found.is_empty or other.is_empty or found.distance(other) >= 2 * RADIUS_M - 1e-6
    assert sum(one.found.target_area_m2 for one in cut) <= 4.0 * half * half + 1e-6


@FEW
@given(team, place)
def test_without_buffers_the_cells_and_the_evaders_share_the_box_out(places: Places, evader: tuple[float, float]) -> None:
    places = [p for p in places if math.dist(p, evader) > 0.01] or [(evader[0] + 1.0, evader[1])]
    half = extent(places, evader)
    areas = [Cut(own, [p for p in places if p != own], evader, half, radius=0.0).found.target_area_m2 for own in places]
    evaders = Cut(evader, places, (evader[0], evader[1]), half, radius=0.0).found.target_area_m2
    assert sum(areas) + evaders == pytest.approx(4.0 * half * half, rel=1e-9)


@FEW
@given(team, place, discs, place)
def test_more_obstacles_never_make_a_cell_larger_and_its_centroid_is_in_it(
    places: Places, evader: tuple[float, float], obstacles: Discs, more: tuple[float, float]
) -> None:
    own, mates = places[0], places[1:]
    before = Cut(own, mates, evader, 12.0, obstacles).found
    after = Cut(own, [*mates, more], evader, 12.0, [*obstacles, (*more, 0.3)])
    assert after.found.target_area_m2 <= before.target_area_m2 + 1e-9
    assert after.found.safety_area_m2 <= before.safety_area_m2 + 1e-9
    if after.found.target_area_m2 > 0.01:
        centroid = shapely.Point(after.found.centroid_n, after.found.centroid_e)
        assert after.target_polygon.buffer(1e-9).contains(centroid)
        assert after.target_polygon.centroid.distance(centroid) < 1e-6


@FEW
@given(team, place, discs, st.sampled_from(["turn", "mirror", "shift", "scale", "relabel"]))
def test_cells_move_with_the_world(places: Places, evader: tuple[float, float], obstacles: Discs, change: str) -> None:
    def moved(p: tuple[float, float]) -> tuple[float, float]:
        n, e = p
        return {"turn": (-e, n), "mirror": (n, -e), "shift": (n + 70.0, e - 30.0), "scale": (3 * n, 3 * e), "relabel": p}[change]

    scale = 3.0 if change == "scale" else 1.0
    mates = places[1:][::-1] if change == "relabel" else places[1:]
    half = (7.0 * scale, 11.0 * scale)
    before = Cut(places[0], places[1:], evader, (7.0, 11.0), obstacles).found
    there = [(*moved((n, e)), scale * r) for n, e, r in obstacles]
    turned = half[::-1] if change == "turn" else half
    after = Cut(moved(places[0]), [moved(p) for p in mates], moved(evader), turned, there, radius=RADIUS_M * scale).found
    assert after.target_area_m2 == pytest.approx(before.target_area_m2 * scale**2, rel=1e-6, abs=1e-6)
    if before.target_area_m2 > 1.0:
        assert (after.centroid_n, after.centroid_e) == pytest.approx(moved((before.centroid_n, before.centroid_e)), abs=1e-6)


IDEAL = Dynamics(1.0, 0.1, 0.0, 0.0, 2.0, 1.0)
HEAVY = Dynamics(5.0, 0.1, 4.0, 0.3, 2.0, 1.0)


@FEW
@given(team, discs, place)
def test_a_held_velocity_ends_in_the_safety_cell_and_is_the_nearest_that_does(
    places: Places, obstacles: Discs, wish: tuple[float, float]
) -> None:
    own = places[0]
    cut = Cut(own, places[1:], (0.0, 0.0), 12.0, obstacles)
    rooms = [np.zeros((40, 2)), np.zeros((40, 2))]
    n, e = held_velocity(*wish, cut.planes, cut.count, IDEAL, np.zeros((40, 3)), *rooms)
    assert math.hypot(n, e) <= 1.0 + 1e-9
    if cut.planes[0, 2] > 1e-6 and cut.count:
        end = np.array((n, e)) * 0.1
        assert (cut.planes[: cut.count, :2] @ end <= cut.planes[: cut.count, 2] + 1e-9).all()
        if (cut.planes[: cut.count, 2] > 0.15).all() and math.hypot(*wish) < 1.0:
            assert (n, e) == pytest.approx(wish, abs=1e-9), "what is safe is left as it is"


def test_a_vehicle_with_inertia_can_always_stop_before_its_planes() -> None:
    for room in (0.05, 0.5, 3.0):
        planes = np.array([[1.0, 0.0, room]])
        n, e = held_velocity(9.0, 0.5, planes, 1, HEAVY, np.zeros((9, 3)), np.zeros((9, 2)), np.zeros((9, 2)))
        assert n * 0.3 + n * n / 8.0 <= room + 1e-9
        assert e == pytest.approx(0.5), "along the plane it is free"
    inside = np.array([[1.0, 0.0, -0.2]])
    n, _ = held_velocity(9.0, 0.0, inside, 1, HEAVY, np.zeros((9, 3)), np.zeros((9, 2)), np.zeros((9, 2)))
    assert n == pytest.approx(-0.4), "it leaves what it must not be in"


def test_between_planes_that_leave_nothing_it_flies_away_from_the_worst() -> None:
    planes = np.array([[1.0, 0.0, -1.0], [-1.0, 0.0, -0.2]])
    n, e = held_velocity(0.0, 1.0, planes, 2, IDEAL, np.zeros((9, 3)), np.zeros((12, 2)), np.zeros((12, 2)))
    assert n == pytest.approx(-1.0)
    assert e == pytest.approx(0.0)

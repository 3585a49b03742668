"""The map: everything of the mission and the fleet is on it, where it belongs."""

from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from flightapp.fleet.messages.sighting import Sighting
from flightapp.watch.data_model_canvas import DOTS_ACROSS, DOTS_DOWN, Canvas, Ink
from flightapp.watch.data_model_fleet import FleetModel
from flightapp.watch.data_model_heard import Heard
from flightapp.watch.data_model_map import ARROWS, MapView, arrow, draw_map
from flightapp.watch.data_model_thresholds import Thresholds
from tests.watch.scenes import DIGEST, MISSION, NOW_S, everybody, heard, state

COLUMNS, ROWS = 36, 13
places = st.tuples(st.floats(-1e4, 1e4), st.floats(-1e4, 1e4))


def drawn(scene: Heard, columns: int = COLUMNS, rows: int = ROWS) -> Canvas:
    return draw_map(MISSION, FleetModel(MISSION, DIGEST, Thresholds()).look(scene), columns, rows)


def inks(canvas: Canvas) -> set[Ink]:
    return {ink for line in canvas.lines() for _, ink in line}


def test_fence_boundary_obstacles_and_vehicles_are_all_on_it_north_up() -> None:
    flying = [
        state("p1", position_ned_m=(5.0, -20.0, -5.0), goal_ned_m=(30.0, -20.0, -5.0)),
        state("p2", NOW_S - 5.0, position_ned_m=(5.0, 15.0, -5.0)),
        state("e1", position_ned_m=(50.0, 0.0, -5.0), yaw_rad=math.pi),
    ]
    canvas = drawn(heard(*flying))
    assert inks(canvas) == set(Ink)
    lines = canvas.plain()
    row_of = {word: next(number for number, line in enumerate(lines) if word in line) for word in ("↑p1", "?p2", "↓e1")}
    assert row_of["↓e1"] < row_of["↑p1"] == row_of["?p2"]
    line = lines[row_of["↑p1"]]
    assert line.index("↑p1") < line.index("?p2"), "west is left"


def test_a_target_that_only_cameras_see_stands_where_they_saw_it() -> None:
    canvas = drawn(heard(*everybody()[:2], sightings={"p1": Sighting(NOW_S, 50.0, 0.0, 0.0, 0.3, 0.1)}))
    assert any("✕e1" in line for line in canvas.plain())


@given(st.lists(places, min_size=3, max_size=3), st.integers(1, 120), st.integers(1, 50))
def test_whoever_flies_away_stays_visible_at_the_edge_of_any_terminal(
    where: list[tuple[float, float]], columns: int, rows: int
) -> None:
    flying = [state(name, position_ned_m=(*place, -5.0)) for name, place in zip(("p1", "p2", "e1"), where, strict=True)]
    canvas = drawn(heard(*flying), columns, rows)
    lines = canvas.plain()
    assert [len(line) for line in lines] == [columns] * rows
    assert any(sign in line for sign in ARROWS for line in lines)


@given(places, places, st.integers(20, 120), st.integers(8, 50))
def test_the_map_has_one_scale_in_both_directions(
    a: tuple[float, float], b: tuple[float, float], columns: int, rows: int
) -> None:
    view = MapView(MISSION, columns, rows)
    assert math.isclose(math.dist(view.dot(a), view.dot(b)) * view.dot_m, math.dist(a, b), rel_tol=1e-6, abs_tol=1e-6)
    for corner in MISSION.flight_volume.vertices_m:
        across, down = view.dot(corner)
        assert 0.0 <= across < columns * DOTS_ACROSS
        assert 0.0 <= down < rows * DOTS_DOWN


@given(st.floats(-math.pi, math.pi))
def test_the_arrow_points_where_the_vehicle_looks_within_an_eighth_of_a_half_turn(yaw_rad: float) -> None:
    shown_rad = ARROWS.index(arrow(yaw_rad)) * math.pi / 4.0
    assert abs(math.remainder(shown_rad - yaw_rad, 2.0 * math.pi)) <= math.pi / 8.0 + 1e-9


def test_every_dot_has_its_own_braille_bit() -> None:
    seen = set()
    for across in range(DOTS_ACROSS):
        for down in range(DOTS_DOWN):
            canvas = Canvas(1, 1)
            canvas.dot((across, down), Ink.FENCE)
            seen.add(canvas.plain()[0])
    assert len(seen) == DOTS_ACROSS * DOTS_DOWN
    full = Canvas(1, 1)
    full.path([(0, 0), (1, 0), (1, 3), (0, 3), (0, 0)], Ink.FENCE)
    assert full.plain() == ["⣿"]

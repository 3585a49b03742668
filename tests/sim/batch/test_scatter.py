"""Scattered scenes: what is drawn leaves room, what is given stands where it was put, and what does not fit is one sentence."""

from __future__ import annotations

import math

import numpy as np
import pytest

from flightapp.core.errors import InputError
from flightapp.planning.plane import crosses, segments
from flightapp.sim.batch import lay_out
from tests.sim.batch.stubs import scenario


def test_drawn_obstacles_leave_room_to_one_another_and_to_the_starts() -> None:
    flown = scenario("field20-40", layout__polygons=10)
    for seed in range(3):
        layout = lay_out(flown, seed)
        assert (len(layout.discs), len(layout.polygons)) == (30, 10)
        circles = [(n, e, radius) for n, e, radius in layout.discs[:, :3].tolist()]
        starts = [(start.north_m, start.east_m) for start in (*layout.pursuers, layout.evader)]
        for i, (n, e, radius) in enumerate(circles):
            assert all(math.dist((n, e), place) >= radius + 0.4 for place in starts)
            assert all(math.dist((n, e), (a, b)) >= radius + other + 0.8 - 1e-9 for a, b, other in circles[:i])
        assert all(math.dist(starts[-1], start) >= 1.5 for start in starts[:-1])


def test_the_evader_of_the_forest_is_never_encircled_at_the_start() -> None:
    flown = scenario("forest")
    for seed in range(8):
        layout = lay_out(flown, seed)
        bearings = sorted(
            math.atan2(start.east_m - layout.evader.east_m, start.north_m - layout.evader.north_m) for start in layout.pursuers
        )
        gaps = np.diff([*bearings, bearings[0] + 2.0 * math.pi])
        assert gaps.max() >= math.pi


def test_the_hunting_tables_are_the_papers() -> None:
    """Rows (x, y, bow angle) as printed: x is east, y north, the angle counter-clockwise from x."""
    layout = lay_out(scenario("hunting-1-free", layout__pursuers__noise_m=0, layout__evader__noise_m=0), 1)
    printed = [(50, 250, -0.1), (110, 90, 0.7), (250, 50, 1.5), (410, 110, 2.4), (450, 290, -2.8), (450, 390, -2.5)]
    for start, (x, y, bow) in zip((*layout.pursuers, layout.evader), printed, strict=True):
        assert (start.east_m, start.north_m) == (x, y)
        assert math.sin(start.heading_rad) == pytest.approx(math.cos(bow), abs=1e-3)
        assert math.cos(start.heading_rad) == pytest.approx(math.sin(bow), abs=1e-3)


def test_a_goal_is_left_by_crossing_the_ring_around_it() -> None:
    layout = lay_out(scenario("hunting-1-free"), 1)
    ring = segments(layout.boundary)
    assert crosses((91.0, 50.0), (91.0, 56.0), ring)
    assert not crosses((91.0, 50.0), (91.0, 54.9), ring)


def test_a_file_on_top_of_another_replaces_starts_and_policies_as_a_whole() -> None:
    flown = scenario("collinear")
    layout = flown.layout.model_dump()
    assert layout["pursuers"]["box_m"] is None
    assert flown.evader.parameters == {}


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"layout__discs": 2000}, "layout.discs = 2000: only"),
        ({"layout__pursuers__apart_m": 30.0}, "layout.pursuers.apart_m = 30.0: only 1 of 7"),
        ({"layout__discs": 0, "layout__discs_m": [[10.0, 10.0, 12.0]]}, "less than 0.16 m from an obstacle"),
        ({"layout__polygons_m": [[[0.0, 0.0], [9.0, 0.0], [1.0, 1.0], [0.0, 9.0]]]}, "polygons_m: number 1 is not convex"),
        ({"layout__polygons_m": [[[0.0, 0.0], [9.0, 0.0], [18.0, 0.0]]]}, "polygons_m: number 1 is not convex or has no area"),
        ({"layout__arena_m": [5.0, 0.0, 4.0, 9.0]}, "must be least north"),
        ({"layout__evader__at_m": [[1.0, 1.0]]}, "give exactly one of at_m, line_m and box_m"),
        ({"layout__pursuers__heading_rad": [0.0]}, "1 headings for 7 vehicles"),
    ],
)
def test_what_does_not_fit_is_one_sentence(changes: dict[str, object], sentence: str) -> None:
    with pytest.raises(InputError) as refusal:
        lay_out(scenario("forest", **changes), 0)
    assert sentence in str(refusal.value)
    assert "\n" not in str(refusal.value)

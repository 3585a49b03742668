"""What the families draw: clear starts, closed traps, a contested geometry, passable gaps."""

from __future__ import annotations

import math

import numpy as np
import pytest

from flightapp.sim.batch import Scenario, lay_out
from flightapp.sim.batch.families.layout import Layout, Start, disc
from flightapp.sim.batch.shortest_path import shortest_path_m
from tests.sim.batch.stubs import scenario

SEEDS = range(51)
FAMILIES = ("a1-u-trap", "a2-dense", "a3-terminal", "a5-suburban")


def clearance_m(layout: Layout, start: Start) -> float:
    if len(layout.discs) == 0:
        return math.inf
    gaps = np.hypot(layout.discs[:, 0] - start.north_m, layout.discs[:, 1] - start.east_m) - layout.discs[:, 2]
    return float(gaps.min())


def boundary_is_contested(of: Scenario, layout: Layout) -> bool:
    """Whether some pursuer is at every point of the boundary before the evader, both on straight ways at full speed."""
    a, b = layout.boundary.vertices_m
    points = a + np.linspace(0.0, 1.0, 200)[:, None] * (b - a)

    def times(start: Start, speed: float) -> np.ndarray:
        return np.hypot(points[:, 0] - start.north_m, points[:, 1] - start.east_m) / speed

    first = np.min([times(start, of.pursuers.speed_max_m_s) for start in layout.pursuers], axis=0)
    return bool((first < times(layout.evader, of.evader.speed_max_m_s)).all())


@pytest.mark.parametrize("name", FAMILIES)
def test_starts_are_clear_and_the_boundary_can_be_defended(name: str) -> None:
    family = scenario(name)
    seen = set()
    for seed in SEEDS if name != "a5-suburban" else range(12):
        layout = lay_out(family, seed)
        assert len(layout.pursuers) == family.pursuers.count
        for start in layout.pursuers:
            assert clearance_m(layout, start) > family.inflation_m
            assert math.dist((start.north_m, start.east_m), (layout.evader.north_m, layout.evader.east_m)) > 5.0
        assert clearance_m(layout, layout.evader) > family.inflation_m
        if name in ("a2-dense", "a3-terminal"):
            assert boundary_is_contested(family, layout)
        seen.add(layout.discs.tobytes() + np.array([layout.evader.north_m, layout.evader.heading_rad]).tobytes())
        again = lay_out(family, seed)
        assert (again.discs == layout.discs).all()
        assert again.pursuers == layout.pursuers
    assert len(seen) > 10


def test_traps_are_closed_and_their_shortest_way_out_is_around_the_walls() -> None:
    family = scenario("a1-u-trap")
    for seed in SEEDS:
        layout = lay_out(family, seed)
        rows = layout.discs
        spacing = np.hypot(*np.diff(rows[:, :2], axis=0).T)
        assert (spacing < 2.0 * 0.5).all()
        (start,) = layout.pursuers
        depth = -float(rows[:, 0].min())
        width = float(rows[:, 1].max() - rows[:, 1].min()) - 1.0
        assert 2.0 <= depth <= 20.0
        assert 4.0 <= width <= 16.0
        assert -depth <= start.north_m < 0.0
        assert abs(start.east_m) < width / 2.0
        assert 12.0 <= layout.evader.north_m - 1.0 <= 15.0
        tips = (rows[0], rows[-1])
        least = min(
            math.dist((start.north_m, start.east_m), tip[:2]) + math.dist(tip[:2], (layout.evader.north_m, 0.0)) for tip in tips
        )
        assert layout.shortest_path_m is not None
        assert layout.shortest_path_m > least
        assert layout.shortest_path_m < least + 2.0 * math.pi


def test_trap_size_can_be_fixed() -> None:
    layout = lay_out(scenario("a1-u-trap", layout__depth_m=8.0, layout__width_m=6.0), 3)
    assert -float(layout.discs[:, 0].min()) == pytest.approx(8.0)
    assert float(np.ptp(layout.discs[:, 1])) - 1.0 == pytest.approx(6.0)


def test_dense_discs_leave_passable_gaps() -> None:
    for seed in SEEDS:
        rows = lay_out(scenario(), seed).discs
        gaps = np.hypot(rows[:, None, 0] - rows[:, 0], rows[:, None, 1] - rows[:, 1]) - rows[:, None, 2] - rows[:, 2]
        assert gaps[~np.eye(len(rows), dtype=bool)].min() >= 2.0


def test_shortest_path_around_one_disc_is_tangent_arc_tangent() -> None:
    """Start and goal 10 m on either side of a disc of 2 m, inflated by 1 m."""
    found = shortest_path_m((-10.0, 0.0), (10.0, 0.0), np.array([disc(0.0, 0.0, 2.0)]), 1.0)
    exact = 2.0 * math.sqrt(10.0**2 - 3.0**2) + 3.0 * (math.pi - 2.0 * math.acos(3.0 / 10.0))
    assert found is not None
    assert exact <= found <= 1.01 * exact


def test_no_way_is_none() -> None:
    ring = [disc(5.0 * math.cos(angle), 5.0 * math.sin(angle), 1.0) for angle in np.linspace(0.0, 2.0 * math.pi, 20)]
    assert shortest_path_m((0.0, 0.0), (20.0, 0.0), np.array(ring), 0.5) is None

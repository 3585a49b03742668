"""Tracking through the whole pipeline, on scenes that a simulated camera sees."""

from __future__ import annotations

import math

import numpy as np
import pytest

from perception.parameters import PerceptionParameters
from perception.pipeline import PerceptionPipeline
from tests.perception.scenes import MOUNTING, MakeStage, pose


def pipeline(**changes: object) -> PerceptionPipeline:
    return PerceptionPipeline(PerceptionParameters(**changes), MOUNTING)


def test_a_turning_vehicle_remembers_what_it_has_passed(scene: MakeStage) -> None:
    trees = [(4.0, 0.0, 0.5, 9.0), (0.0, 4.0, 0.4, 9.0), (-4.0, -1.0, 0.6, 9.0)]
    process, world = pipeline(), scene(cylinders=trees)
    for step in range(80):
        at = pose(yaw_deg=math.degrees(2.0 * step / 30))
        found = process.process(world.shoot(at), at)
    # After 5.2 rad the second tree was last seen 1.5 s ago, the third 0.5 s ago.
    for north, east, radius, _ in trees[1:]:
        gap = np.hypot(found.discs[:, 0] - north, found.discs[:, 1] - east)
        assert gap.min() < 0.25
        assert found.discs[gap.argmin(), 2] == pytest.approx(radius, abs=0.3)
    assert len(found.discs) <= 6
    for north, east, radius in found.discs[:, :3]:
        assert world.world.signed_distance_m(north, east, -5.0) + radius < 0.5


def test_memory_grows_and_fades(scene: MakeStage) -> None:
    process, world = pipeline(memory_s=1.0, memory_growth_m_s=0.1), scene(cylinders=[(4.0, 0.0, 0.5, 9.0)])
    first = process.process(world.shoot(pose()), pose()).discs[0, 2]
    away = pose(yaw_deg=180.0)
    radii = [process.process(world.shoot(away), away).discs[:, 2].tolist() for _ in range(35)]
    assert radii[14] == pytest.approx([first + 0.05], abs=1e-9)
    assert radii[-1] == []


def test_a_place_seen_free_is_forgotten(scene: MakeStage) -> None:
    process = pipeline()
    with_pole, without = scene(cylinders=[(4.0, 0.0, 0.3, 9.0)]), scene(boxes=[(7.0, 0.0, 0.5, 6.0, 9.0, 0.0)])
    assert len(process.process(with_pole.shoot(pose()), pose()).discs) == 1
    without.number = 1
    assert process.process(without.shoot(pose()), pose()).discs[:, 0].min() > 6.0


def test_what_is_hidden_behind_something_nearer_is_remembered(scene: MakeStage) -> None:
    process = pipeline()
    open_view, blocked = scene(cylinders=[(6.0, 0.0, 0.3, 9.0)]), scene(boxes=[(3.0, 0.0, 0.5, 3.0, 9.0, 0.0)])
    process.process(open_view.shoot(pose()), pose())
    blocked.number = 1
    discs = process.process(blocked.shoot(pose()), pose()).discs
    assert np.hypot(discs[:, 0] - 6.0, discs[:, 1]).min() < 0.3


def test_a_vehicle_that_flies_by_leaves_no_trail(scene: MakeStage) -> None:
    process, world = pipeline(), scene()
    for step in range(60):
        north, east = 5.0, -6.0 + 0.2 * step
        body = np.array([[north, east, -5.0, 0.35]])
        found = process.process(world.shoot(pose(), body), pose(), np.array([[north, east, 0.8]]))
        assert len(found.discs) == 0


@pytest.mark.parametrize(("speed_m_s", "radius_m"), [(1.5, 0.3), (5.0, 0.35)])
def test_a_body_that_crosses_has_a_velocity_within_half_a_second_and_the_trees_have_none(
    scene: MakeStage, speed_m_s: float, radius_m: float
) -> None:
    process, world = pipeline(), scene(cylinders=[(6.5, -3.0, 0.3, 9.0), (7.0, 3.5, 0.3, 9.0)])
    for step in range(24):
        t_s = step / 30
        at = pose(north=0.5 * t_s, yaw_deg=5.0 * math.sin(4.0 * t_s))
        east = -0.4 * speed_m_s + speed_m_s * t_s
        found = process.process(world.shoot(at, np.array([[4.0, east, -5.0, radius_m]])), at)
        gap = np.hypot(found.discs[:, 0] - 4.0, found.discs[:, 1] - east)
        body = int(gap.argmin())
        assert gap[body] < 0.4
        assert not found.discs[gap > 1.0, 3:5].any()
        if t_s >= 0.5:
            assert found.discs[body, 3:5] == pytest.approx([0.0, speed_m_s], abs=0.6)


def test_nothing_that_stands_has_a_velocity_in_a_fast_turning_flight(scene: MakeStage) -> None:
    trees = [(4.0 + 3.0 * k, 2.5 * (-1) ** k, 0.25, 9.0) for k in range(8)]
    process, world = pipeline(), scene(cylinders=trees, boxes=[(14.0, 7.0, 30.0, 0.5, 9.0, 0.0)])
    for step in range(75):
        t_s = step / 30
        truth = pose(north=8.0 * t_s, roll_deg=10 * math.sin(2.0 * t_s), pitch_deg=-8.0, yaw_deg=57.0 * math.sin(2.0 * t_s))
        believed = pose(
            north=8.0 * t_s,
            roll_deg=10 * math.sin(2.0 * t_s) + math.sin(5.0 * t_s),
            pitch_deg=-8.0 + math.cos(4.0 * t_s),
            yaw_deg=57.0 * math.sin(2.0 * t_s) + math.cos(3.0 * t_s),
        )
        found = process.process(world.shoot(truth), believed)
        assert not found.discs[:, 3:5].any(), step


def test_turning_on_the_spot_does_not_multiply_discs(scene: MakeStage) -> None:
    trees = [(4.0, 0.0, 0.3, 9.0), (0.0, 5.0, 0.4, 9.0), (-4.0, -1.0, 0.2, 9.0)]
    process, world = pipeline(memory_s=4.0), scene(cylinders=trees, boxes=[(0.0, -6.0, 8.0, 0.5, 9.0, 0.0)])
    counts = []
    for step in range(205):
        at = pose(yaw_deg=math.degrees(2.0 * step / 30))
        found = process.process(world.shoot(at), at)
        assert not found.discs[:, 3:5].any()
        counts.append(len(found.discs))
    turn = 95
    assert max(counts[turn:]) <= max(counts[:turn]) + 4
    for north, east, _, _ in trees:
        assert np.count_nonzero(np.hypot(found.discs[:, 0] - north, found.discs[:, 1] - east) < 0.8) == 1

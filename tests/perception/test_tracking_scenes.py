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

"""What perception tells of the place of a vehicle that is left out of the obstacles."""

from __future__ import annotations

import math

import numpy as np
import pytest

from perception.parameters import PerceptionParameters
from perception.pipeline import PerceptionPipeline
from tests.perception.scenes import MOUNTING, MakeStage, pose

BODY_M = 0.3
NOWHERE = (math.nan, math.nan, math.nan)


def _pipeline() -> PerceptionPipeline:
    return PerceptionPipeline(PerceptionParameters(), MOUNTING, ground_down_m=0.0)


@pytest.mark.parametrize("distance_m", [2.0, 4.0, 6.0, 8.0])
def test_a_vehicle_that_is_left_out_is_placed_all_the_same(scene: MakeStage, distance_m: float) -> None:
    """The expected place is 0.3 m off; the row before it is no circle, and stays without a place."""
    world = scene()
    at = np.array([distance_m, 0.2 * distance_m])
    exclude = np.array([NOWHERE, (at[0] + 0.2, at[1] - 0.2, 0.7)])
    found = _pipeline().process(world.shoot(pose(), np.array([[*at, -5.0, BODY_M]])), pose(), exclude)
    assert len(found.discs) == 0
    assert np.isnan(found.left_out[0]).all()
    surface = at - at / np.linalg.norm(at) * 0.785 * BODY_M
    assert np.linalg.norm(found.left_out[1] - surface) < 0.05 + 0.004 * distance_m**2


def test_nothing_there_is_no_place(scene: MakeStage) -> None:
    found = _pipeline().process(scene().shoot(pose()), pose(), np.array([[5.0, 0.0, 0.7]]))
    assert found.left_out.shape == (1, 2)
    assert np.isnan(found.left_out).all()


def test_a_wall_through_the_place_is_not_the_vehicle(scene: MakeStage) -> None:
    world = scene([], [(5.0, 0.0, 0.3, 6.0, 9.0, 0.0)])
    found = _pipeline().process(world.shoot(pose()), pose(), np.array([[5.0, 0.0, 0.7]]))
    assert np.isnan(found.left_out).all()


def test_where_a_tree_stood_before_nobody_can_tell_the_two_apart(scene: MakeStage) -> None:
    world, process = scene([(5.0, 0.0, 0.25, 9.0)]), _pipeline()
    for _ in range(45):
        assert len(process.process(world.shoot(pose()), pose()).discs) == 1
    found = process.process(world.shoot(pose()), pose(), np.array([[5.1, 0.1, 0.7]]))
    assert len(found.discs) == 0
    assert np.isnan(found.left_out).all()

"""Obstacles are found where they are, whatever the vehicle's attitude; ground and speckle are not obstacles."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from perception.parameters import PerceptionParameters
from perception.pipeline import PerceptionPipeline
from perception.types import DepthFrame
from tests.perception.scenes import D435, MOUNTING, MakeStage, Stage, outside_m, pose, visible_band

ATTITUDES = [(0.0, 0.0), (20.0, 0.0), (-15.0, 10.0), (5.0, -20.0), (0.0, 20.0), (-20.0, -20.0)]


def pipeline(**changes: object) -> PerceptionPipeline:
    return PerceptionPipeline(PerceptionParameters(memory_s=0.0, **changes), MOUNTING)


@pytest.mark.parametrize(("roll", "pitch"), ATTITUDES)
@pytest.mark.parametrize("distance", [2.0, 5.0, 8.0])
@pytest.mark.parametrize("radius", [0.05, 0.5, 0.9])
def test_a_pole_or_tree_is_one_disc_in_its_place(
    scene: MakeStage, roll: float, pitch: float, distance: float, radius: float
) -> None:
    world = scene(cylinders=[(distance, 0.4, radius, 9.0)])
    at = pose(roll_deg=roll, pitch_deg=pitch)
    found = pipeline().process(world.shoot(at), at)
    assert found.events == ()
    assert len(found.discs) == 1
    north, east, disc_radius = found.discs[0, :3]
    front = math.hypot(north, east) - disc_radius
    sigma = 0.004 * distance**2
    assert front == pytest.approx(math.hypot(distance, 0.4) - radius, abs=0.1 + sigma)
    assert math.atan2(east, north) == pytest.approx(math.atan2(0.4, distance), abs=0.03)
    assert max(radius, 0.15) == pytest.approx(disc_radius, abs=0.12 + 0.1 * radius + sigma / 2)


@pytest.mark.parametrize(("roll", "pitch"), ATTITUDES)
@pytest.mark.parametrize("distance", [2.0, 5.0, 7.5])
@pytest.mark.parametrize("heading", [0.0, 35.0, 70.0])
def test_a_wall_lies_inside_its_discs_and_they_are_small(
    scene: MakeStage, roll: float, pitch: float, distance: float, heading: float
) -> None:
    boxes = [(distance + 1.0, 0.5, 0.4, 3.0, 9.0, heading)]
    at = pose(roll_deg=roll, pitch_deg=pitch)
    true_surface = visible_band(scene(boxes=boxes, noise=False).shoot(at), at)
    world = scene(boxes=boxes)
    found = pipeline().process(world.shoot(at), at)
    true_surface = true_surface[np.hypot(*true_surface.T) < 8.5]
    if len(true_surface):
        assert np.quantile(outside_m(true_surface, found.discs), 0.99) < 0.1 + 0.002 * distance**2
    for north, east, radius in found.discs[:, :3]:
        assert radius < 0.9
        assert world.world.signed_distance_m(north, east, -5.0) < 0.45 + 0.004 * distance**2


def test_a_wall_ahead_is_a_row_of_small_discs(scene: MakeStage) -> None:
    found = pipeline().process(scene(boxes=[(5.0, 0.0, 0.3, 20.0, 9.0, 0.0)]).shoot(pose()), pose())
    assert 8 <= len(found.discs) <= 30
    assert found.discs[:, 2].max() < 0.75
    assert (found.discs[:, 0] - found.discs[:, 2]).min() > 4.85 - 0.3


def test_both_visible_sides_of_a_hut_are_covered(scene: MakeStage) -> None:
    boxes = [(6.0, 0.5, 3.0, 2.5, 8.0, 30.0)]
    true_surface = visible_band(scene(boxes=boxes, noise=False).shoot(pose()), pose())
    found = pipeline().process(scene(boxes=boxes).shoot(pose()), pose())
    assert np.quantile(outside_m(true_surface, found.discs), 0.99) < 0.15


def test_a_near_pole_before_a_wall_is_told_from_it(scene: MakeStage) -> None:
    world = scene(cylinders=[(3.0, 0.0, 0.1, 9.0)], boxes=[(7.0, 0.0, 0.5, 12.0, 9.0, 0.0)])
    discs = pipeline().process(world.shoot(pose()), pose()).discs
    near = discs[discs[:, 0] < 5.0]
    assert len(near) == 1
    assert near[0, :2] == pytest.approx([3.0, 0.0], abs=0.15)
    between = np.column_stack([np.linspace(3.8, 6.0, 20), np.zeros(20)])
    assert outside_m(between, discs).min() > 0.0


@given(
    roll=st.floats(-20, 20),
    pitch=st.floats(-20, 20),
    distance=st.floats(1.5, 8.0),
    bearing_deg=st.floats(-25, 25),
    radius=st.floats(0.04, 1.0),
    seed=st.integers(0, 1000),
)
@settings(max_examples=40, deadline=None)
def test_what_is_seen_of_a_cylinder_lies_inside_the_discs(
    roll: float, pitch: float, distance: float, bearing_deg: float, radius: float, seed: int
) -> None:
    centre = distance + radius
    bearing = math.radians(bearing_deg)
    cylinders = [(centre * math.cos(bearing), centre * math.sin(bearing), radius, 9.0)]
    at = pose(roll_deg=roll, pitch_deg=pitch)
    true_surface = visible_band(Stage(cylinders, [], False, 0).shoot(at), at)
    true_surface = true_surface[np.hypot(*true_surface.T) < 8.5]
    found = pipeline().process(Stage(cylinders, [], True, seed).shoot(at), at)
    assert len(found.discs) >= 1
    assert np.quantile(outside_m(true_surface, found.discs), 0.98) < 0.1 + 0.003 * distance**2


@pytest.mark.parametrize("height", [0.3, 1.2, 2.0, 5.0])
@pytest.mark.parametrize("pitch", [-30.0, -15.0, 0.0, 15.0, 30.0])
def test_the_ground_is_never_an_obstacle(scene: MakeStage, height: float, pitch: float) -> None:
    world, process = scene(seed=7), pipeline()
    for roll in (-30.0, 0.0, 12.0):
        for _ in range(3):
            at = pose(height=height, roll_deg=roll, pitch_deg=pitch)
            assert len(process.process(world.shoot(at), at).discs) == 0


def test_an_attitude_error_of_a_degree_does_not_raise_the_ground(scene: MakeStage) -> None:
    world = scene()
    for error in (-1.0, 1.0):
        frame = world.shoot(pose(height=1.5, pitch_deg=-5.0))
        wrong = pose(height=1.5, pitch_deg=-5.0 + error, roll_deg=error)
        assert len(pipeline().process(frame, wrong).discs) == 0


@pytest.mark.parametrize("fraction", [0.001, 0.01])
def test_speckle_is_not_an_obstacle(scene: MakeStage, fraction: float) -> None:
    random = np.random.default_rng(5)
    process, world = pipeline(), scene()
    for _ in range(30):
        frame = world.shoot(pose())
        speckle = random.random(frame.depth.shape) < fraction
        frame.depth[speckle] = random.integers(300, 10000, speckle.sum(), dtype=np.uint16)
        assert len(process.process(frame, pose()).discs) == 0


def test_far_noise_is_not_an_obstacle() -> None:
    random = np.random.default_rng(5)
    depth = random.integers(15000, 30000, (480, 848), dtype=np.uint16)
    found = pipeline().process(DepthFrame(0.0, 1, depth, 0.001, D435), pose(pitch_deg=20.0))
    assert len(found.discs) == 0


def test_what_stands_just_beyond_the_range_does_not_flicker_into_it(scene: MakeStage) -> None:
    world, process = scene(boxes=[(11.1, 0.0, 0.4, 12.0, 9.0, 0.0)]), pipeline()
    for _ in range(20):
        for north, _, radius in process.process(world.shoot(pose()), pose()).discs[:, :3]:
            assert north - radius > 9.0


@pytest.mark.parametrize("stride", [1, 3, 4, 8])
def test_any_stride_finds_the_same_pole(scene: MakeStage, stride: int) -> None:
    frame = scene(cylinders=[(5.0, -1.0, 0.3, 9.0)]).shoot(pose())
    found = pipeline(stride_px=stride).process(frame, pose())
    assert len(found.discs) == 1
    assert found.discs[0, :3] == pytest.approx([5.0, -1.0, 0.3], abs=0.2)


def test_what_is_above_or_below_the_band_does_not_count(scene: MakeStage) -> None:
    world = scene(cylinders=[(4.0, 0.0, 0.5, 3.5)])
    assert len(pipeline().process(world.shoot(pose(height=5.0)), pose(height=5.0)).discs) == 0
    assert len(pipeline().process(world.shoot(pose(height=4.0)), pose(height=4.0)).discs) == 1


def test_at_most_the_nearest_discs_go_out(scene: MakeStage) -> None:
    frame = scene(boxes=[(5.0, 0.0, 0.3, 20.0, 9.0, 0.0)]).shoot(pose())
    everything = pipeline().process(frame, pose()).discs
    few = pipeline(discs_max=3).process(frame, pose()).discs
    assert np.array_equal(few, everything[:3])
    gaps = np.hypot(everything[:, 0], everything[:, 1]) - everything[:, 2]
    assert np.all(np.diff(gaps) >= 0)

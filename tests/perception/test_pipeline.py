"""Bad frames, blind sectors, vehicles that are not obstacles."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest

from perception.parameters import PerceptionParameters
from perception.pipeline import PerceptionPipeline
from perception.types import DepthFrame, PerceivedObstacles, VehiclePose
from tests.perception.scenes import D435, MOUNTING, MakeStage, pose

WHOLE = [[-math.pi, math.pi]]


def pipeline(**changes: object) -> PerceptionPipeline:
    return PerceptionPipeline(PerceptionParameters(**changes), MOUNTING)


def is_unseen(found: PerceivedObstacles, bearing_deg: float) -> bool:
    bearing = math.radians(bearing_deg)
    return any(start <= bearing < end for start, end in found.unseen)


BAD_IMAGES = {
    "empty": (np.zeros((480, 848), np.uint16), "empty"),
    "maximum": (np.full((480, 848), 65535, np.uint16), "maximum"),
    "truncated": (np.full((300, 848), 3000, np.uint16), "wrong size: 848x300 instead of 848x480"),
    "nothing": (np.zeros((0, 0), np.uint16), "wrong size"),
    "flat": (np.zeros(100, np.uint16), "wrong size"),
    "bytes": (np.ones((480, 848), np.uint8), "16-bit"),
}


@pytest.mark.parametrize("name", BAD_IMAGES)
def test_a_bad_frame_is_an_event_and_an_unseen_circle(name: str) -> None:
    image, reason = BAD_IMAGES[name]
    found = pipeline().process(DepthFrame(1.0, 1, image, 0.001, D435), pose())
    assert reason in found.events[0]
    assert found.unseen.tolist() == WHOLE
    assert found.discs.shape == (0, 7)


@pytest.mark.parametrize("field", range(3))
def test_a_pose_that_is_not_a_number_is_an_event(scene: MakeStage, field: int) -> None:
    bad = [
        VehiclePose((0.0, math.nan, 0.0), (0.0, 0.0, 0.0), 0.0, 0.0, 0.0),
        VehiclePose((0.0, 0.0, -5.0), (math.inf, 0.0, 0.0), 0.0, 0.0, 0.0),
        VehiclePose((0.0, 0.0, -5.0), (0.0, 0.0, 0.0), 0.0, 0.0, math.nan),
    ][field]
    found = pipeline().process(scene(cylinders=[(4.0, 0.0, 0.5, 9.0)]).shoot(pose()), bad)
    assert "not finite" in found.events[0]
    assert found.unseen.tolist() == WHOLE


def test_a_bad_frame_keeps_what_is_remembered(scene: MakeStage) -> None:
    process = pipeline()
    world = scene(cylinders=[(4.0, 0.0, 0.5, 9.0)])
    process.process(world.shoot(pose()), pose())
    dark = DepthFrame(2 / 30, 2, np.zeros((480, 848), np.uint16), 0.001, D435)
    found = process.process(dark, pose())
    assert found.unseen.tolist() == WHOLE
    assert found.discs[0, :2] == pytest.approx([4.0, 0.0], abs=0.2)


def test_outside_the_picture_is_unseen(scene: MakeStage) -> None:
    for yaw in (0.0, 90.0, 170.0, -100.0):
        at = pose(height=2.0, yaw_deg=yaw)
        found = pipeline().process(scene().shoot(at), at)
        assert found.events == ()
        for offset in (-40.0, 0.0, 40.0):
            assert not is_unseen(found, (yaw + offset + 180.0) % 360.0 - 180.0)
        for offset in (-55.0, 55.0, 120.0, 179.0):
            assert is_unseen(found, (yaw + offset + 180.0) % 360.0 - 180.0)
        assert np.all(found.unseen[:, 0] < found.unseen[:, 1])


def test_half_a_covered_lens_is_half_unseen(scene: MakeStage) -> None:
    at = pose(height=2.0)
    frame = scene().shoot(at)
    frame.depth[:, :424] = 0
    found = pipeline().process(frame, at)
    assert "blind" in found.events[0]
    assert is_unseen(found, -30.0)
    assert is_unseen(found, -8.0)
    assert not is_unseen(found, 20.0)


def test_a_covered_lens_is_noticed_at_once_where_the_ground_was_due(scene: MakeStage) -> None:
    process, at = pipeline(), pose(height=5.0)
    assert process.process(scene().shoot(at), at).events == ()
    found = process.process(DepthFrame(0.06, 2, np.zeros((480, 848), np.uint16), 0.001, D435), at)
    assert "ground" in found.events[0]
    assert found.unseen.tolist() == WHOLE


def test_open_sky_proves_nothing_and_is_unseen_at_once(scene: MakeStage) -> None:
    process, world = pipeline(), scene()
    assert process.process(world.shoot(pose()), pose()).unseen.tolist() != WHOLE
    up = pose(pitch_deg=35.0)
    found = process.process(world.shoot(up), up)
    assert found.unseen.tolist() == WHOLE
    assert "empty" in found.events[0]


def test_a_pitch_that_hides_the_height_band_is_unseen(scene: MakeStage) -> None:
    at = pose(height=3.0, pitch_deg=-50.0)
    assert pipeline().process(scene().shoot(at), at).unseen.tolist() == WHOLE


def test_a_frozen_image_is_noticed(scene: MakeStage) -> None:
    process = pipeline(frozen_frames_max=10)
    image = scene(cylinders=[(4.0, 0.0, 0.5, 9.0)]).shoot(pose()).depth
    events = [process.process(DepthFrame(k / 30, k, image, 0.001, D435), pose()).events for k in range(12)]
    assert all(event == () for event in events[:10])
    assert "frozen" in events[10][0]


@pytest.mark.parametrize("distance", [1.5, 4.0, 8.0])
def test_vehicles_are_not_obstacles_but_the_tree_behind_them_is(scene: MakeStage, distance: float) -> None:
    world = scene(cylinders=[(distance + 2.0, 1.5, 0.5, 9.0)] if distance < 7 else [])
    process = pipeline()
    body = np.array([[distance, 0.0, -5.0, 0.35]])
    seen = process.process(world.shoot(pose(), body), pose()).discs
    assert np.hypot(seen[:, 0] - distance, seen[:, 1]).min() < 0.5
    exclude = np.array([[distance, 0.0, 0.8]])
    for _ in range(10):
        found = process.process(world.shoot(pose(), body), pose(), exclude).discs
        assert len(found) == len(world.world.cylinders)
        assert not len(found) or np.hypot(found[0, 0] - distance - 2.0, found[0, 1] - 1.5) < 0.3


def test_an_exclusion_without_numbers_excludes_nothing(scene: MakeStage) -> None:
    frame = scene(cylinders=[(4.0, 0.0, 0.5, 9.0)]).shoot(pose())
    found = pipeline().process(frame, pose(), np.array([[math.nan, 0.0, 2.0], [4.0, 0.0, math.inf], [4.0, 0.0, 0.0]]))
    assert len(found.discs) == 1


def test_flying_through_a_wood_stays_honest_and_small(scene: MakeStage) -> None:
    random = np.random.default_rng(3)
    trees = [(float(n), float(e), 0.3 + 0.3 * random.random(), 9.0) for n in range(4, 44, 5) for e in range(-12, 13, 6)]
    trees = [(n, e + 3.0 * (i % 2), r, h) for i, (n, e, r, h) in enumerate(trees)]
    process, world = pipeline(), scene(cylinders=trees)
    for step in range(120):
        t = step / 30
        at = pose(north=4.0 * t, east=math.sin(t), roll_deg=15 * math.sin(3 * t), pitch_deg=-8.0, yaw_deg=30 * math.sin(1.5 * t))
        found = process.process(world.shoot(at), at)
        assert len(found.discs) <= 60
        for north, east, radius in found.discs[:, :3]:
            assert world.world.signed_distance_m(north, east, -5.0) + radius < 1.2


def test_a_frame_takes_less_than_a_tenth_of_its_period(scene: MakeStage) -> None:
    process, world = pipeline(), scene(boxes=[(4.0, 0.0, 0.5, 12.0, 9.0, 0.0)])
    frames = [world.shoot(pose()) for _ in range(20)]
    took = []
    for frame in frames:
        start = time.thread_time()
        process.process(frame, pose())
        took.append(time.thread_time() - start)
    assert min(took) < 0.0033

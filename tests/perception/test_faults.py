"""Frames, lens data and poses that are wrong: one clear event, nothing seen, no exception."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from perception.geometry import CameraMounting
from perception.parameters import PerceptionParameters
from perception.pipeline import PerceptionPipeline
from perception.types import DepthFrame, Intrinsics, PerceivedObstacles, VehiclePose
from tests.perception.scenes import D435, MOUNTING, MakeStage, pose

WHOLE = [[-math.pi, math.pi]]


def process(frame: DepthFrame, at: VehiclePose, mounting: CameraMounting = MOUNTING) -> PerceivedObstacles:
    return PerceptionPipeline(PerceptionParameters(), mounting).process(frame, at)


def assert_nothing_seen(found: PerceivedObstacles, reason: str) -> None:
    assert len(found.events) == 1
    assert reason in found.events[0]
    assert found.unseen.tolist() == WHOLE


def is_unseen(found: PerceivedObstacles, bearing_deg: float) -> bool:
    return any(start <= math.radians(bearing_deg) < end for start, end in found.unseen)


@pytest.fixture
def frame(scene: MakeStage) -> DepthFrame:
    return scene(cylinders=[(4.0, 0.0, 0.5, 9.0)]).shoot(pose(height=2.0))


@pytest.mark.parametrize(
    ("lens", "reason"),
    [
        (Intrinsics(640, 480, 421.6, 421.6, 320.0, 240.0), "wrong size: 848x480 instead of 640x480"),
        (replace(D435, cx_px=900.0), "cx_px = 900 lies outside"),
        (replace(D435, cy_px=-1.0), "cy_px = -1 lies outside"),
        (replace(D435, fx_px=math.nan), "fx_px = nan"),
        (replace(D435, fy_px=0.0), "fy_px = 0"),
        (replace(D435, fx_px="421"), "must be a number"),
        (replace(D435, width_px=848.5), "whole number of pixels"),
    ],
)
def test_lens_data_that_cannot_be_are_named(frame: DepthFrame, lens: Intrinsics, reason: str) -> None:
    assert_nothing_seen(process(replace(frame, intrinsics=lens), pose(height=2.0)), reason)


def test_whole_numbers_are_lens_data_like_any(frame: DepthFrame) -> None:
    whole, exact = Intrinsics(848, 480, 422, 422, 424, 240), Intrinsics(848, 480, 422.0, 422.0, 424.0, 240.0)
    one, other = (process(replace(frame, intrinsics=lens), pose(height=2.0)) for lens in (whole, exact))
    assert np.array_equal(one.discs, other.discs)
    assert np.array_equal(one.unseen, other.unseen)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda image: image[:300], "wrong size: 848x300"),
        (lambda image: image.T, "wrong size: 480x848"),
        (lambda image: image.astype(np.float32), "float32 instead of uint16"),
        (lambda image: image.astype(">u2"), "16-bit"),
        (lambda image: image.tolist(), "no array of pixels"),
        (lambda image: np.full_like(image, 120), "lens is covered"),
        (lambda image: np.where(np.arange(848) < 800, 65535, image).astype(np.uint16), "maximum"),
    ],
    ids=[
        "truncated",
        "turned by 90 degrees",
        "floats",
        "big-endian",
        "list",
        "covered by something near",
        "nearly all at maximum",
    ],
)
def test_pictures_that_cannot_be_are_named(frame: DepthFrame, change: object, reason: str) -> None:
    assert_nothing_seen(process(replace(frame, depth=change(frame.depth)), pose(height=2.0)), reason)  # type: ignore[operator]


@pytest.mark.parametrize("unit", [math.nan, 0.0, -0.001, 1.0])
def test_a_depth_unit_that_cannot_be_is_named(frame: DepthFrame, unit: float) -> None:
    assert_nothing_seen(process(replace(frame, depth_unit_m=unit), pose(height=2.0)), "depth_unit_m")


def test_a_depth_unit_ten_times_too_large_contradicts_the_ground(frame: DepthFrame) -> None:
    found = process(replace(frame, depth_unit_m=0.01), pose(height=2.0))
    assert found.events
    assert found.unseen.tolist() == WHOLE


def test_a_picture_upside_down_shows_nothing(frame: DepthFrame) -> None:
    found = process(replace(frame, depth=np.ascontiguousarray(frame.depth[::-1, ::-1])), pose(height=2.0))
    assert found.events
    assert found.unseen.tolist() == WHOLE


def test_an_array_that_is_not_contiguous_is_read_like_any(frame: DepthFrame) -> None:
    strided = np.repeat(frame.depth, 2, axis=1)[:, ::2]
    assert not strided.flags["C_CONTIGUOUS"]
    one, other = process(frame, pose(height=2.0)), process(replace(frame, depth=strided), pose(height=2.0))
    assert np.array_equal(one.discs, other.discs)


@pytest.mark.parametrize("value", [0, 120], ids=["nothing returns", "nearer than can be measured"])
@pytest.mark.parametrize(
    ("rows", "columns", "hidden_deg"),
    [((0, 480), (0, 424), -20.0), ((240, 480), (0, 200), -35.0), ((0, 480), (600, 848), 35.0)],
    ids=["left half", "lower left corner", "right side"],
)
def test_a_finger_hides_what_it_covers(
    frame: DepthFrame, rows: tuple[int, int], columns: tuple[int, int], hidden_deg: float, value: int
) -> None:
    frame.depth[slice(*rows), slice(*columns)] = value
    found = process(frame, pose(height=2.0))
    assert is_unseen(found, hidden_deg)
    assert not is_unseen(found, -hidden_deg)


@pytest.mark.parametrize("position", [1e6, 1e300])
def test_a_position_off_the_earth_is_named(frame: DepthFrame, position: float) -> None:
    at = replace(pose(height=2.0), position_ned_m=(position, 0.0, -2.0))
    assert_nothing_seen(process(frame, at), "position_ned_m")


def test_a_mounting_that_points_too_far_down_by_30_degrees_is_noticed(scene: MakeStage) -> None:
    at = pose(height=2.0)
    level = scene().shoot(at)
    found = process(level, at, CameraMounting(forward_m=0.1, pitch_deg=-30.0))
    assert_nothing_seen(found, "contradicts the ground")


def test_a_height_told_too_low_by_5_m_is_noticed(scene: MakeStage) -> None:
    found = process(scene().shoot(pose(height=6.0, pitch_deg=-20.0)), pose(height=1.0, pitch_deg=-20.0))
    assert_nothing_seen(found, "contradicts the ground")

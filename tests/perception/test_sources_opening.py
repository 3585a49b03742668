"""What a person types opens the right source, or is answered in one sentence."""

from __future__ import annotations

import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from perception.errors import PerceptionInputError
from perception.geometry import CameraMounting
from perception.sources import PngFolderSource, RealSenseRecordingSource, SourceOptions, open_source
from perception.sources.synthetic import SyntheticSource
from perception.synthetic.scene import Scene
from perception.types import Intrinsics, VehiclePose
from tests.perception.software_camera import SoftwareCamera, sdk

SMALL = Intrinsics(64, 48, 32.0, 32.0, 32.0, 24.0)


def test_a_recording_of_the_camera_is_opened_by_its_suffix(tmp_path: Path) -> None:
    SoftwareCamera().record(tmp_path / "camera.db3", [1])
    source = open_source(str(tmp_path / "camera.db3"), SourceOptions())
    source.close()
    assert isinstance(source, RealSenseRecordingSource)


def test_images_are_opened_with_the_intrinsics_and_the_rate_that_were_given(tmp_path: Path) -> None:
    for number in range(2):
        cv2.imwrite(str(tmp_path / f"{number}.png"), np.full((48, 64), number, np.uint16))
    source = open_source(str(tmp_path), SourceOptions(intrinsics=SMALL, rate_hz=10.0, depth_unit_m=0.0001))
    assert isinstance(source, PngFolderSource)
    frames = [source.latest() for _ in range(3)]
    assert [(frame.t_s, frame.intrinsics, frame.depth_unit_m) for frame in frames if frame] == [
        (0.0, SMALL, 0.0001),
        (0.1, SMALL, 0.0001),
    ]
    one = open_source(str(tmp_path / "1.png"), SourceOptions(intrinsics=SMALL)).latest()
    assert one is not None
    assert int(one.depth[0, 0]) == 1


def test_images_without_intrinsics_are_refused(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "1.png"), np.zeros((48, 64), np.uint16))
    with pytest.raises(PerceptionInputError, match="carry no intrinsics"):
        open_source(str(tmp_path), SourceOptions())


@pytest.mark.parametrize("what", ["webcam", "/nowhere/folder", ""])
def test_what_names_nothing_is_answered_with_what_could_be_named(what: str) -> None:
    with pytest.raises(PerceptionInputError, match=r"no such file, folder or camera; wanted is realsense .*synthetic.*\.mcap"):
        open_source(what, SourceOptions())


def test_a_file_that_is_missing_is_named_with_its_kind(tmp_path: Path) -> None:
    for name in ("none.png", "none.mcap"):
        with pytest.raises(PerceptionInputError, match=name):
            open_source(str(tmp_path / name), SourceOptions(intrinsics=SMALL))


def test_a_camera_needs_its_number_after_the_colon_and_the_sdk(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(PerceptionInputError, match="the serial number is missing"):
        open_source("realsense:", SourceOptions())
    monkeypatch.setitem(sys.modules, "pyrealsense2", None)
    with pytest.raises(PerceptionInputError, match="install the extra 'realsense'"):
        open_source("realsense:123", SourceOptions())


def test_a_camera_that_is_not_there_is_named() -> None:
    sdk()
    with pytest.raises(PerceptionInputError, match="camera 000000000000 is not there"):
        open_source("realsense:000000000000", SourceOptions())


def test_the_synthetic_source_shows_obstacles_from_a_moving_vehicle_and_ends() -> None:
    source = open_source("synthetic", SourceOptions(width_px=212, height_px=120, rate_hz=6.0))
    frames = []
    while not source.is_finished:
        frame = source.latest()
        assert frame is not None
        frames.append(frame)
    assert source.latest() is None
    assert len(frames) == 60
    assert [frame.number for frame in frames] == list(range(60))
    first, last = frames[0].pose, frames[-1].pose
    assert first is not None
    assert last is not None
    assert last.position_ned_m[0] - first.position_ned_m[0] > 10
    assert all(frame.depth.any() for frame in frames)


def test_a_synthetic_frame_is_what_stands_there_seen_from_the_pose_it_carries() -> None:
    wall = Scene(boxes=np.array([[10.0, 0.0, 1.0, 40.0, 20.0, 0.0]]))

    def motion(t_s: float) -> VehiclePose:
        return VehiclePose((2.0 * t_s, 0.0, -5.0), (2.0, 0.0, 0.0), 0.0, 0.0, 0.0)

    source = SyntheticSource(
        wall, SMALL, motion, mounting=CameraMounting(forward_m=0.5), rate_hz=2.0, duration_s=1.5, noise=False
    )
    frames = [source.latest() for _ in range(4)]
    assert frames[3] is None
    for k, frame in enumerate(frames[:3]):
        assert frame is not None
        assert (frame.t_s, frame.pose) == (0.5 * k, motion(0.5 * k))
        assert frame.depth_unit_m * int(frame.depth[24, 32]) == pytest.approx(9.5 - 0.5 - k, abs=0.002)
    source.close()
    assert source.is_finished

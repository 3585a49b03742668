"""Recordings of a RealSense: every frame to the last, the pace that was asked for, one sentence on a file that is none."""

from __future__ import annotations

import sqlite3
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from perception.errors import PerceptionInputError
from perception.sources import DepthSource, RealSenseRecordingSource
from perception.types import DepthFrame, Intrinsics
from tests.perception.software_camera import LENS, SoftwareCamera, sdk

OLD_BAG = Path(__file__).parent / "data" / "four_frames_sdk_2_55.bag"
"""Frames 1 to 4, 32x24, filled with their numbers, 33.3 ms apart: written by SDK 2.55.1 from its software device."""


@pytest.fixture(autouse=True)
def _needs_the_sdk() -> None:
    sdk()


def played(file: Path, pause_s: float = 0.0) -> tuple[list[DepthFrame], DepthSource]:
    """All frames (pixels copied) of the recording, read as fast as it can be."""
    source: DepthSource = RealSenseRecordingSource(file, now_s=time.monotonic)
    frames = []
    deadline = time.monotonic() + 30
    while not source.is_finished:
        assert time.monotonic() < deadline, "the end was never told"
        frame = source.latest()
        if frame is not None:
            frames.append(DepthFrame(frame.t_s, frame.number, frame.depth.copy(), frame.depth_unit_m, frame.intrinsics))
            time.sleep(pause_s)
    source.close()
    return frames, source


@pytest.mark.parametrize("pause_s", [0.0, 0.003])
def test_every_frame_of_a_recording_comes_however_slow_the_reader(tmp_path: Path, pause_s: float) -> None:
    numbers = [*range(1, 30), *range(40, 60)]
    SoftwareCamera().record(tmp_path / "camera.db3", numbers)
    frames, source = played(tmp_path / "camera.db3", pause_s)
    assert [frame.number for frame in frames] == numbers
    assert all(np.array_equal(frame.depth, np.full((48, 64), frame.number)) for frame in frames)
    assert {(frame.intrinsics, frame.depth_unit_m) for frame in frames} == {(LENS, 0.001)}
    assert [frame.t_s for frame in frames] == pytest.approx([(number - 1) / 30 for number in numbers], abs=1e-5)
    assert (source.health.received, source.health.skipped, source.health.lost) == (49, 0, 10)
    assert source.latest() is None


def test_an_older_bag_plays_too() -> None:
    frames, _ = played(OLD_BAG)
    assert [frame.number for frame in frames] == [1, 2, 3, 4]
    assert [(int(frame.depth.min()), int(frame.depth.max())) for frame in frames] == [(k, k) for k in (1, 2, 3, 4)]
    assert frames[0].intrinsics == Intrinsics(32, 24, 16.5, 17.5, 15.5, 12.5)
    assert [frame.t_s for frame in frames] == pytest.approx([0.0, 0.0333, 0.0666, 0.0999], abs=1e-6)


def test_in_real_time_the_newest_frame_counts_as_taken_now(tmp_path: Path) -> None:
    SoftwareCamera().record(tmp_path / "camera.db3", [1, 2, 3])
    opened_s = time.monotonic()
    source = RealSenseRecordingSource(tmp_path / "camera.db3", now_s=time.monotonic, is_real_time=True)
    frames = []
    while not source.is_finished:
        assert time.monotonic() < opened_s + 20
        frame = source.latest()
        if frame is not None:
            frames.append(frame)
            assert opened_s < frame.t_s <= time.monotonic()
    source.close()
    assert frames[-1].number == 3, "the last frame is the newest"


def test_closing_in_the_middle_ends_at_once(tmp_path: Path) -> None:
    SoftwareCamera().record(tmp_path / "camera.db3", list(range(1, 30)))
    source = RealSenseRecordingSource(tmp_path / "camera.db3", now_s=time.monotonic)
    while source.latest() is None:
        time.sleep(0.001)
    source.close()
    source.close()
    assert source.is_finished
    assert source.latest() is None


def _cut(file: Path) -> None:
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])


def _foreign(file: Path) -> None:
    file.unlink()
    with sqlite3.connect(file) as database:
        database.execute("create table notes (text)")


@pytest.mark.parametrize(
    "spoil", [_cut, _foreign, lambda file: file.write_bytes(b""), lambda file: file.write_bytes(b"no recording" * 999)]
)
@pytest.mark.parametrize("suffix", [".db3", ".bag"])
def test_a_file_that_is_no_whole_recording_is_named(tmp_path: Path, suffix: str, spoil: Callable[[Path], None]) -> None:
    file = tmp_path / f"camera{suffix}"
    if suffix == ".bag":
        file.write_bytes(OLD_BAG.read_bytes())
    else:
        SoftwareCamera().record(file, [1, 2, 3])
    spoil(file)
    with pytest.raises(PerceptionInputError, match=rf"camera\{suffix}: not a whole recording") as caught:
        RealSenseRecordingSource(file, now_s=time.monotonic)
    assert "\n" not in str(caught.value)


def test_a_recording_without_frames_is_over_and_says_why(tmp_path: Path) -> None:
    SoftwareCamera().record(tmp_path / "camera.db3", [1, 2])
    with sqlite3.connect(tmp_path / "camera.db3") as database:
        database.execute("delete from messages where topic_id in (select id from topics where name like '%/image/%')")
    now_s = [0.0]
    source = RealSenseRecordingSource(tmp_path / "camera.db3", now_s=lambda: now_s[0])
    assert source.latest() is None
    now_s[0] = 10.0
    deadline = time.monotonic() + 20
    while not source.is_finished and time.monotonic() < deadline:
        assert source.latest() is None
    source.close()
    assert source.health.fault.endswith("camera.db3: holds no depth frame")
    SoftwareCamera().record(tmp_path / "nothing.db3", [])
    with pytest.raises(PerceptionInputError, match=r"nothing\.db3: has no depth sensor"):
        RealSenseRecordingSource(tmp_path / "nothing.db3", now_s=time.monotonic)


def test_a_recording_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(PerceptionInputError, match=r"none\.db3: no such recording"):
        RealSenseRecordingSource(tmp_path / "none.db3", now_s=time.monotonic)
    (tmp_path / "film.mp4").write_bytes(b"film")
    with pytest.raises(PerceptionInputError, match=r"film\.mp4: not a recording of the RealSense SDK; a \.db3 or \.bag"):
        RealSenseRecordingSource(tmp_path / "film.mp4", now_s=time.monotonic)

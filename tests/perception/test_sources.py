"""Camera sources: newest wins, nothing torn, one sentence on bad input."""

from __future__ import annotations

import multiprocessing
import time
from pathlib import Path

import cv2
import numpy as np
import pytest

from perception.errors import PerceptionInputError
from perception.sources import DepthSource, PngFolderSource, RealSenseSource, SharedMemorySource, SharedMemoryWriter
from perception.sources.clock_mapping import CaptureClock
from perception.types import Intrinsics

SMALL = Intrinsics(64, 48, 50.0, 51.0, 32.0, 24.0)


def image(value: int) -> np.ndarray:
    return np.full((48, 64), value, np.uint16)


def seconds(ns: int) -> float:
    return ns * 1e-9 + 100.0


def test_the_reader_waits_for_the_file_and_gets_what_was_written(tmp_path: Path) -> None:
    source: DepthSource = SharedMemorySource(tmp_path / "camera", seconds)
    assert source.latest() is None
    writer = SharedMemoryWriter(tmp_path / "camera", SMALL, 0.0005)
    assert source.latest() is None
    writer.write(image(7), 2_500_000_000)
    frame = source.latest()
    assert frame is not None
    assert (frame.t_s, frame.number, frame.depth_unit_m, frame.intrinsics) == (102.5, 1, 0.0005, SMALL)
    assert np.array_equal(frame.depth, image(7))
    assert source.latest() is None
    source.close()
    writer.close()


def test_the_newest_frame_wins_and_skipped_ones_are_counted(tmp_path: Path) -> None:
    writer, source = SharedMemoryWriter(tmp_path / "camera", SMALL), SharedMemorySource(tmp_path / "camera", seconds)
    for value in range(1, 4):
        writer.write(image(value), value)
    first = source.latest()
    assert first is not None
    assert (first.number, source.health.skipped) == (3, 0)
    for value in range(4, 9):
        writer.write(image(value), value)
    second = source.latest()
    assert second is not None
    assert (second.number, int(second.depth[0, 0]), source.health.skipped, source.health.received) == (8, 8, 4, 2)
    assert int(first.depth[0, 0]) == 3, "the frame before must stay as it was"


def test_a_restarted_camera_is_followed(tmp_path: Path) -> None:
    source = SharedMemorySource(tmp_path / "camera", seconds)
    writer = SharedMemoryWriter(tmp_path / "camera", SMALL)
    writer.write(image(1), 1)
    assert source.latest() is not None
    writer.close()
    again = SharedMemoryWriter(tmp_path / "camera", Intrinsics(32, 16, 20.0, 20.0, 16.0, 8.0))
    again.write(np.full((16, 32), 9, np.uint16), 2)
    frame = source.latest()
    assert frame is not None
    assert frame.depth.shape == (16, 32)
    assert int(frame.depth[0, 0]) == 9


@pytest.mark.parametrize("content", [b"", b"short", b"X" * 5000])
def test_a_foreign_file_is_no_camera(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "camera").write_bytes(content)
    assert SharedMemorySource(tmp_path / "camera", seconds).latest() is None


def test_a_frame_of_the_wrong_size_is_refused(tmp_path: Path) -> None:
    writer = SharedMemoryWriter(tmp_path / "camera", SMALL)
    with pytest.raises(ValueError, match="shape"):
        writer.write(np.zeros((10, 10), np.uint16), 1)


def _write_many(path: Path, count: int) -> None:
    writer = SharedMemoryWriter(path, SMALL)
    for value in range(1, count + 1):
        writer.write(image(value % 60000), value)


def test_no_frame_is_torn_while_another_process_writes_as_fast_as_it_can(tmp_path: Path) -> None:
    count = 20000
    process = multiprocessing.get_context("spawn").Process(target=_write_many, args=(tmp_path / "camera", count))
    process.start()
    source = SharedMemorySource(tmp_path / "camera", seconds)
    deadline = time.monotonic() + 20
    last = 0
    while last < count and time.monotonic() < deadline:
        frame = source.latest()
        if frame is None:
            continue
        assert frame.number > last
        assert frame.depth.min() == frame.depth.max() == frame.number % 60000
        last = frame.number
    process.join(10)
    assert last == count
    assert source.health.received > 10
    assert source.health.received + source.health.skipped <= count


def test_recorded_frames_come_in_the_order_of_their_numbers(tmp_path: Path) -> None:
    for number in (10, 9, 1):
        cv2.imwrite(str(tmp_path / f"{number}.png"), image(number))
    source = PngFolderSource(tmp_path, SMALL, period_s=0.1)
    frames = [source.latest() for _ in range(4)]
    assert [None if frame is None else int(frame.depth[0, 0]) for frame in frames] == [1, 9, 10, None]
    assert frames[2] is not None
    assert frames[2].t_s == pytest.approx(0.2)


def test_recorded_frames_that_are_none_are_named(tmp_path: Path) -> None:
    with pytest.raises(PerceptionInputError, match=r"nowhere: no such file"):
        PngFolderSource(tmp_path / "nowhere", SMALL)
    with pytest.raises(PerceptionInputError, match=r"has no \.png file"):
        PngFolderSource(tmp_path, SMALL)
    cv2.imwrite(str(tmp_path / "eight.png"), image(3).astype(np.uint8))
    with pytest.raises(PerceptionInputError, match=r"eight\.png: 8-bit image"):
        PngFolderSource(tmp_path / "eight.png", SMALL).latest()
    (tmp_path / "broken.png").write_bytes(b"\x89PNG nonsense")
    with pytest.raises(PerceptionInputError, match=r"broken\.png: not a readable image"):
        PngFolderSource(tmp_path / "broken.png", SMALL).latest()


def test_unix_stamps_give_the_age_of_a_frame() -> None:
    clock = CaptureClock(lambda: 50.0, lambda: 1000.0)
    assert clock.capture_s(999.97, is_unix=True) == pytest.approx(49.97)
    assert clock.capture_s(1000.5, is_unix=True) == 50.0


def test_stamps_of_the_cameras_clock_follow_the_quickest_frame() -> None:
    now = [0.0]
    clock = CaptureClock(lambda: now[0], lambda: 0.0)
    captured = []
    for k, delay in enumerate([0.02, 0.005, 0.03, 0.01]):
        now[0] = 10.0 + k / 30 + delay
        captured.append(clock.capture_s(3.0 + k / 30, is_unix=False))
    assert captured[1:] == pytest.approx([10.005 + k / 30 for k in (1, 2, 3)])


def test_a_realsense_recording_plays_through_the_camera_source(tmp_path: Path) -> None:
    rs = pytest.importorskip(
        "pyrealsense2", reason="pyrealsense2 or its system library libusb-1.0-0 is missing", exc_type=ImportError
    )
    file = tmp_path / "camera.db3"
    _record(rs, file, 8)
    source: DepthSource = RealSenseSource(now_s=time.monotonic, unix_s=time.time, recording=file)
    values: list[int] = []
    deadline = time.monotonic() + 10
    while 8 not in values and time.monotonic() < deadline:
        frame = source.latest()
        if frame is not None:
            values.append(int(frame.depth[0, 0]))
            assert frame.depth.min() == frame.depth.max()
            assert frame.depth_unit_m == pytest.approx(0.001)
            assert (frame.intrinsics.fx_px, frame.intrinsics.cy_px) == (421.5, 240.5)
            assert frame.t_s <= time.monotonic()
    source.close()
    assert values == sorted(set(values))
    assert values[-1] == 8
    assert source.health.received == len(values)


def test_a_missing_realsense_recording_is_named(tmp_path: Path) -> None:
    pytest.importorskip("pyrealsense2", reason="pyrealsense2 or its system library libusb-1.0-0 is missing", exc_type=ImportError)
    with pytest.raises(PerceptionInputError, match=r"none\.db3: no such recording"):
        RealSenseSource(now_s=time.monotonic, unix_s=time.time, recording=tmp_path / "none.db3")


def _record(rs: object, file: Path, count: int) -> None:
    """Frames with the values 1 to `count`, recorded from the SDK's software device."""
    device = rs.software_device()
    sensor = device.add_sensor("Stereo Module")
    lens = rs.intrinsics()
    lens.width, lens.height, lens.fx, lens.fy, lens.ppx, lens.ppy = 848, 480, 421.5, 421.5, 424.5, 240.5
    lens.model, lens.coeffs = rs.distortion.none, [0.0] * 5
    stream = rs.video_stream()
    stream.type, stream.index, stream.uid, stream.width, stream.height = rs.stream.depth, 0, 1, 848, 480
    stream.fps, stream.bpp, stream.fmt, stream.intrinsics = 30, 2, rs.format.z16, lens
    profile = sensor.add_video_stream(stream, True)
    sensor.add_read_only_option(rs.option.depth_units, 0.001)
    sensor.add_read_only_option(rs.option.stereo_baseline, 50.0)
    device.create_matcher(rs.matchers.default)
    recorder = rs.recorder(str(file), device)
    recorded = recorder.query_sensors()[0]
    queue = rs.frame_queue(50)
    recorded.open(recorded.get_stream_profiles()[0])
    recorded.start(queue)
    keep = []
    for value in range(1, count + 1):
        pixels = np.full((480, 848), value, np.uint16)
        keep.append(pixels)
        frame = rs.software_video_frame()
        frame.pixels, frame.stride, frame.bpp = pixels, 848 * 2, 2
        frame.timestamp, frame.domain = 1000.0 + value * 33.3, rs.timestamp_domain.hardware_clock
        frame.frame_number, frame.profile, frame.depth_units = value, profile.as_video_stream_profile(), 0.001
        sensor.on_video_frame(frame)
    recorded.stop()
    recorded.close()
    del recorder, recorded, sensor, device

"""Shared memory and folders of images: newest wins, nothing torn, one sentence on bad input."""

from __future__ import annotations

import multiprocessing
import time
from pathlib import Path

import cv2
import numpy as np
import pytest

from perception.errors import PerceptionInputError
from perception.sources import DepthSource, PngFolderSource, SharedMemorySource, SharedMemoryWriter
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


def test_images_come_at_the_times_that_stand_beside_them(tmp_path: Path) -> None:
    for number in range(3):
        cv2.imwrite(str(tmp_path / f"{number}.png"), image(number))
    times = tmp_path / "timestamps.txt"
    times.write_text("1700000000.5\n1700000000.75\n1700000002\n")
    source = PngFolderSource(tmp_path, SMALL)
    frames = [source.latest() for _ in range(3)]
    assert [None if frame is None else frame.t_s for frame in frames] == [0.0, 0.25, 1.5]
    assert source.is_finished
    for text, sentence in (
        ("1\n2\n", "2 times for 3 images"),
        ("1\n2\n2\n", r"line 3: 2\.0 is not after 2\.0"),
        ("1\n2\nnan\n", "line 3: nan is not after"),
        ("1\n2\nthree\n", "one time in seconds a line"),
    ):
        times.write_text(text)
        with pytest.raises(PerceptionInputError, match=rf"timestamps\.txt: .*{sentence}"):
            PngFolderSource(tmp_path, SMALL)

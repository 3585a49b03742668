"""A RealSense, as the SDK's software device: pixels kept, newest wins, silence ended, one sentence on what is wrong."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from perception.errors import PerceptionInputError
from perception.sources import DepthSource, RealSenseSource, open_camera
from perception.sources.realsense_device import choose_camera
from perception.sources.realsense_stream import DepthMode, DepthStream
from tests.perception.software_camera import LENS, SERIAL_NUMBER, SoftwareCamera, sdk

MODE = DepthMode(LENS.width_px, LENS.height_px, 30.0)
Opening = Callable[..., RealSenseSource]


@pytest.fixture
def opened() -> Iterator[Opening]:
    """Opens sources that are closed after the test."""
    sources: list[RealSenseSource] = []

    def open_one(camera: SoftwareCamera | Callable[[], Any], **options: Any) -> RealSenseSource:
        find = camera if callable(camera) else lambda: camera.device
        settings = {"now_s": time.monotonic, "unix_s": time.time, "mode": MODE, **options}
        sources.append(RealSenseSource(find_device=find, **settings))
        return sources[-1]

    yield open_one
    for source in sources:
        source.close()


def wait_until(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 20
    while not condition():
        assert time.monotonic() < deadline, "waited for 20 s"
        time.sleep(0.01)


def test_a_frame_arrives_with_its_pixels_lens_unit_and_number(opened: Opening) -> None:
    camera = SoftwareCamera(depth_unit_m=0.0005)
    source: DepthSource = opened(camera)
    assert source.latest() is None
    pixels = np.random.default_rng(1).integers(0, 65536, (48, 64)).astype(np.uint16)
    camera.send(pixels, 17)
    frame = source.latest()
    assert frame is not None
    assert np.array_equal(frame.depth, pixels)
    assert frame.depth.flags.c_contiguous
    assert (frame.number, frame.depth_unit_m, frame.intrinsics) == (17, 0.0005, LENS)
    assert source.latest() is None, "every frame comes once"
    assert not source.is_finished


def test_the_newest_frame_wins_and_what_was_skipped_or_lost_is_told_apart(opened: Opening) -> None:
    camera = SoftwareCamera()
    source = opened(camera)
    for number in (5, 6, 9):
        camera.send(number, number)
    frame = source.latest()
    assert frame is not None
    assert frame.number == 9
    health = source.health
    assert (health.received, health.skipped, health.lost, health.fault) == (1, 2, 2, "")


def test_a_frame_stays_as_it_is_until_the_second_next_one(opened: Opening) -> None:
    camera = SoftwareCamera()
    source = opened(camera)
    frames = []
    for value in (1, 2):
        camera.send(value, value)
        frames.append(source.latest())
    assert [int(frame.depth.max()) for frame in frames if frame is not None] == [1, 2]


def test_a_camera_that_counts_from_the_start_again_has_lost_nothing(opened: Opening) -> None:
    camera = SoftwareCamera()
    source = opened(camera)
    for number in (1000, 1001, 1, 2):
        camera.send(number, number)
        assert source.latest() is not None
    assert source.health.lost == 0


def test_a_frame_in_the_hosts_time_is_as_old_as_it_says(opened: Opening) -> None:
    camera = SoftwareCamera()
    source = opened(camera, now_s=lambda: 50.0, unix_s=lambda: 1_700_000_000.0)
    camera.send(1, 1, stamp_s=1_700_000_000.0 - 0.035, is_unix=True)
    frame = source.latest()
    assert frame is not None
    assert frame.t_s == pytest.approx(50.0 - 0.035, abs=1e-5)


def test_frames_in_the_cameras_time_are_as_far_apart_as_it_says(opened: Opening) -> None:
    now_s = [50.0]
    camera = SoftwareCamera()
    source = opened(camera, now_s=lambda: now_s[0], unix_s=lambda: 0.0)
    times = []
    for number, late_s in enumerate((0.0, 0.004, 0.001)):
        now_s[0] = 50.0 + number / 30 + late_s
        camera.send(1, number, stamp_s=7.0 + number / 30)
        frame = source.latest()
        assert frame is not None
        times.append(frame.t_s)
    assert np.diff(times) == pytest.approx([1 / 30, 1 / 30], abs=1e-5)


def test_a_silent_stream_is_started_again_and_says_so_until_frames_come(opened: Opening) -> None:
    camera = SoftwareCamera()
    source = opened(camera, stall_timeout_s=0.2)
    camera.send(1, 900, stamp_s=40.0)
    assert source.latest() is not None
    wait_until(lambda: source.health.restarts == 1)
    assert f"({SERIAL_NUMBER}): no frame for" in source.health.fault
    assert source.latest() is None
    camera.send(2, 3, stamp_s=0.1)
    frame = source.latest()
    assert frame is not None
    assert int(frame.depth[0, 0]) == 2
    assert time.monotonic() - frame.t_s < 5, "a camera whose clock starts anew is believed at once"
    assert (source.health.fault, source.health.lost) == ("", 0)


def test_an_unplugged_camera_is_looked_for_until_it_is_back(opened: Opening) -> None:
    plugged = [SoftwareCamera()]

    def find() -> Any:
        return choose_camera({camera.serial_number: camera.device for camera in plugged}, SERIAL_NUMBER)

    source = opened(find, stall_timeout_s=0.2)
    plugged[0].send(1, 1)
    assert source.latest() is not None
    plugged.clear()
    wait_until(lambda: "is not there" in source.health.fault)
    assert source.latest() is None
    assert source.health.restarts == 0
    back = SoftwareCamera()
    plugged.append(back)
    wait_until(lambda: source.health.restarts == 1)
    back.send(7, 1)
    frame = source.latest()
    assert frame is not None
    assert int(frame.depth[0, 0]) == 7
    assert source.health.fault == ""


def test_whatever_the_driver_raises_on_the_way_back_latest_raises_nothing(opened: Opening) -> None:
    camera = SoftwareCamera()
    found = [camera.device]

    def find() -> Any:
        if not found:
            raise OSError("the bus is gone")
        return found.pop()

    source = opened(find, stall_timeout_s=0.2)
    camera.send(1, 1)
    assert source.latest() is not None
    wait_until(lambda: "the bus is gone" in source.health.fault)
    assert source.latest() is None


def test_the_temperature_is_told_where_the_camera_tells_it(opened: Opening) -> None:
    source = opened(SoftwareCamera(temperature_c=41.5))
    wait_until(lambda: source.health.temperature_c is not None)
    assert source.health.temperature_c == pytest.approx(41.5)
    assert DepthStream(sdk(), SoftwareCamera().device, None).temperature_c() is None


def test_a_camera_on_usb_2_works_with_a_warning(opened: Opening) -> None:
    camera = SoftwareCamera(usb="2.1")
    source = opened(camera)
    camera.send(1, 1)
    assert source.latest() is not None
    assert "USB 2.1" in source.health.warning
    assert source.health.fault == ""
    assert opened(SoftwareCamera(usb="3.2")).health.warning == ""


def test_closing_twice_is_closing(opened: Opening) -> None:
    camera = SoftwareCamera()
    source = opened(camera)
    source.close()
    source.close()
    camera.send(1, 1)
    assert source.latest() is None


def test_a_mode_that_the_camera_lacks_is_answered_with_those_it_has(opened: Opening) -> None:
    with pytest.raises(PerceptionInputError, match=r"64x48 at 75 Hz is not offered; it has 64x48 at 30/90 Hz$"):
        opened(SoftwareCamera(), mode=DepthMode(64, 48, 75.0))
    with pytest.raises(PerceptionInputError, match=r"848x480 at 30 Hz is not offered.* is connected by USB 2\.1"):
        opened(SoftwareCamera(usb="2.1"), mode=DepthMode(848, 480, 30.0))


def test_a_device_without_depth_is_named(opened: Opening) -> None:
    device = sdk().software_device()
    device.add_sensor("RGB Camera")
    with pytest.raises(PerceptionInputError, match="has no depth sensor"):
        opened(lambda: device)


def test_the_camera_is_chosen_by_its_serial_number() -> None:
    cameras = {"111": "one", "222": "two"}
    assert choose_camera(cameras, "222") == "two"
    assert choose_camera({"111": "one"}, None) == "one"
    with pytest.raises(PerceptionInputError, match=r"camera 333 is not there; connected are: 111, 222"):
        choose_camera(cameras, "333")
    with pytest.raises(PerceptionInputError, match=r"several .* name one by its serial number: 111, 222"):
        choose_camera(cameras, None)
    with pytest.raises(PerceptionInputError, match=r"no RealSense camera is connected"):
        choose_camera({}, None)


def test_without_the_sdk_the_sentence_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyrealsense2", None)
    with pytest.raises(PerceptionInputError, match=r"extra 'realsense' and the system library libusb-1\.0-0"):
        open_camera(now_s=time.monotonic, unix_s=time.time, mode=MODE)

"""Depth in the recording: what the camera saw comes back to the bit, and perception never waits for it."""

from __future__ import annotations

import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from numpy.typing import NDArray

from flightapp.config.profile import RecordingOptions
from flightapp.core.types import VehicleState
from flightapp.recording import depth
from flightapp.recording.reader import read_recording
from flightapp.recording.recorder import Recorder
from flightapp.recording.recover import recover
from flightapp.runtime.depth_recording import DepthRecording, Pace, RecordedSource
from flightapp.vehicle.autopilot import Motion
from flightapp.vehicle.pose_history import PoseHistory
from perception.sources import SourceHealth
from perception.sources.mcap import McapSource
from perception.types import DepthFrame
from tests.recording.depth_flight import CAMERA, EVERY_FRAME, LENS, expected_north_m, frames, history, record
from tests.recording.samples import T0_S, own
from tests.recording.test_recorder import GatedFile, wait_for

ROOT = Path(__file__).resolve().parents[2]


class Gate:
    """A compression that does not come back until it is let."""

    def __init__(self) -> None:
        self.open = threading.Event()
        self.entered = threading.Semaphore(0)

    def __call__(self, pixels: NDArray[np.uint16]) -> bytes:
        self.entered.release()
        assert self.open.wait(20.0)
        return depth.png(pixels)


class Playing:
    """A camera that shows `shots` one after the other in the same memory, as cameras do."""

    def __init__(self, shots: list[DepthFrame]) -> None:
        self._shots = list(shots)
        self._memory = np.zeros_like(shots[0].depth)
        self.closed = False
        self.health = SourceHealth(received=7)

    @property
    def is_finished(self) -> bool:
        return not self._shots

    def latest(self) -> DepthFrame | None:
        if not self._shots:
            return None
        shot = self._shots.pop(0)
        self._memory[:] = shot.depth
        return DepthFrame(shot.t_s, shot.number, self._memory, shot.depth_unit_m, shot.intrinsics)

    def close(self) -> None:
        self.closed = True


def decoded(path: Path, topic: str) -> list[tuple[str, Any]]:
    """(schema name, message) of one of Foxglove's channels."""
    with path.open("rb") as file:
        messages = make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages(topics=[topic])
        return [(schema.name, message) for schema, _, _, message in messages]


@pytest.mark.parametrize("stride", [1, 2, 4])
def test_pixels_come_back_to_the_bit_with_the_intrinsics_that_belong_to_them(tmp_path: Path, stride: int) -> None:
    shots = frames(3)
    options = RecordingOptions(depth_rate_hz=90.0, depth_stride=stride)
    path = record(tmp_path / "p1.mcap", shots, history(), options)
    images = decoded(path, "/depth")
    assert len(images) == 3
    infos = read_recording(path).topic("/depth/info").messages
    for shot, (schema, image), info in zip(shots, images, infos, strict=True):
        assert (schema, image.format) == ("foxglove.CompressedImage", "png")
        pixels = cv2.imdecode(np.frombuffer(image.data, np.uint8), cv2.IMREAD_UNCHANGED)
        np.testing.assert_array_equal(pixels, shot.depth[::stride, ::stride])
        assert pixels.dtype == np.uint16
        row, column = 8 // stride, 12 // stride  # the same pixel of the camera looks in the same direction
        assert (column - info["cx_px"]) / info["fx_px"] == pytest.approx((12 - LENS.cx_px) / LENS.fx_px)
        assert (row - info["cy_px"]) / info["fy_px"] == pytest.approx((8 - LENS.cy_px) / LENS.fy_px)
        assert (info["height_px"], info["width_px"]) == pixels.shape
        assert (info["t_s"], info["frame_number"], info["depth_unit_m"]) == (shot.t_s, shot.number, 0.00025)


def test_the_pose_is_the_one_at_the_capture_time(tmp_path: Path) -> None:
    shots = frames(5)
    infos = read_recording(record(tmp_path / "p1.mcap", shots, history())).topic("/depth/info").messages
    for shot, info in zip(shots, infos, strict=True):
        assert info["position_ned_m"] == pytest.approx([expected_north_m(shot.t_s), 1.0, -5.0], abs=1e-6)
        assert info["velocity_ned_m_s"] == pytest.approx([2.0, 0.0, 0.0])
        assert info["roll_rad"] == pytest.approx(0.1 * (shot.t_s - T0_S), abs=1e-6)
        assert info["mounting"]["pitch_deg"] == -10.0


def test_the_pose_waits_for_the_telemetry_after_the_frame(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a vehicle that has just begun to turn, the messages before the frame alone would say that it does not."""
    monkeypatch.setattr("flightapp.runtime.depth_recording.TELEMETRY_ATTEMPTS", 1_000_000)
    known, (shot,), asked = PoseHistory(), frames(1), threading.Event()

    class Watched(PoseHistory):
        @property
        def newest_s(self) -> float:
            asked.set()
            return known.newest_s

        def at(self, t_s: float) -> Motion | None:
            return known.at(t_s)

    def hear(t_s: float, yaw_rad: float) -> None:
        known.append_attitude(t_s, 0.0, 0.0, yaw_rad)
        known.append_state(VehicleState(t_s, np.zeros(3), np.zeros(3), yaw_rad))

    hear(T0_S - 0.03, 0.0)
    hear(T0_S - 0.01, 0.0)
    with Recorder(tmp_path / "p1.mcap") as recorder:
        recording = DepthRecording(recorder, Watched(), CAMERA, EVERY_FRAME)
        recording.offer(shot)
        assert asked.wait(5.0)
        hear(T0_S + 0.01, 0.2)
        recording.close()
    (info,) = read_recording(tmp_path / "p1.mcap").topic("/depth/info").messages
    assert info["yaw_rad"] == pytest.approx(0.1)


def test_a_frame_before_any_telemetry_is_recorded_without_a_pose(tmp_path: Path) -> None:
    info = read_recording(record(tmp_path / "p1.mcap", frames(1), PoseHistory())).topic("/depth/info").messages[0]
    assert info["position_ned_m"] is None
    assert info["yaw_rad"] is None


def test_foxglove_gets_the_intrinsics_as_a_camera_calibration(tmp_path: Path) -> None:
    ((schema, calibration),) = decoded(record(tmp_path / "p1.mcap", frames(1), history()), "/depth/calibration")
    assert schema == "foxglove.CameraCalibration"
    assert (calibration.width, calibration.height) == (LENS.width_px, LENS.height_px)
    assert list(calibration.K) == [LENS.fx_px, 0.0, LENS.cx_px, 0.0, LENS.fy_px, LENS.cy_px, 0.0, 0.0, 1.0]
    (_, image), *_ = decoded(tmp_path / "p1.mcap", "/depth")
    assert image.frame_id == calibration.frame_id
    assert image.timestamp.ToNanoseconds() == calibration.timestamp.ToNanoseconds()


def test_without_the_option_nothing_of_it_is_in_the_file(tmp_path: Path) -> None:
    assert RecordingOptions().depth_rate_hz == 0.0
    with Recorder(tmp_path / "p1.mcap") as recorder:
        recorder.log("/own", own(T0_S), T0_S)
    with (tmp_path / "p1.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    assert not [channel.topic for channel in summary.channels.values() if channel.topic.startswith("/depth")]


def test_a_compression_that_hangs_costs_frames_not_time(tmp_path: Path) -> None:
    gate, shots = Gate(), frames(10)
    with Recorder(tmp_path / "p1.mcap") as recorder:
        recording = DepthRecording(recorder, history(), CAMERA, EVERY_FRAME, gate)
        source = RecordedSource(Playing(shots), recording)
        assert source.latest() is not None
        assert gate.entered.acquire(timeout=5.0)  # the thread is inside a compression that does not return
        taken = [source.latest() for _ in range(9)]
        assert not gate.open.is_set()  # all nine returned while it hung
        assert [frame.number for frame in taken if frame is not None] == [shot.number for shot in shots[1:]]
        assert recording.dropped == 8  # the newest waits in the slot
        gate.open.set()
        source.close()
    infos = read_recording(tmp_path / "p1.mcap").topic("/depth/info").messages
    assert [(info["frame_number"], info["dropped"]) for info in infos] == [(100, 8), (109, 8)]
    images = [cv2.imdecode(np.frombuffer(image.data, np.uint8), -1) for _, image in decoded(tmp_path / "p1.mcap", "/depth")]
    np.testing.assert_array_equal(images, [shots[0].depth, shots[9].depth])  # and not what the camera's memory shows now


def test_closing_gives_up_on_a_compression_that_hangs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("flightapp.runtime.depth_recording.CLOSE_TIMEOUT_S", 0.05)
    gate = Gate()
    with Recorder(tmp_path / "p1.mcap") as recorder:
        recording = DepthRecording(recorder, history(), CAMERA, EVERY_FRAME, gate)
        camera = Playing(frames(1))
        source = RecordedSource(camera, recording)
        source.latest()
        assert gate.entered.acquire(timeout=5.0)
        source.close()
        assert camera.closed
        gate.open.set()


def test_a_compression_that_fails_costs_that_frame_only(tmp_path: Path) -> None:
    def fails_at_first(pixels: NDArray[np.uint16]) -> bytes:
        if done.acquire(blocking=False):
            raise MemoryError("no room")
        return depth.png(pixels)

    done, shots = threading.Semaphore(1), frames(2)
    with Recorder(tmp_path / "p1.mcap") as recorder:
        recording = DepthRecording(recorder, history(), CAMERA, EVERY_FRAME, fails_at_first)
        recording.offer(shots[0])
        wait_for(lambda: recording.dropped == 1)
        recording.offer(shots[1])
        recording.close()
    infos = read_recording(tmp_path / "p1.mcap").topic("/depth/info").messages
    assert [(info["frame_number"], info["dropped"]) for info in infos] == [(101, 1)]


@pytest.mark.parametrize("shape", [(0,), (40, 30, 3), (0, 0)])
def test_odd_frames_pass_unharmed(tmp_path: Path, shape: tuple[int, ...]) -> None:
    odd = DepthFrame(T0_S, 1, np.zeros(shape, np.uint16), 0.001, LENS)
    with Recorder(tmp_path / "p1.mcap") as recorder:
        recording = DepthRecording(recorder, history(), CAMERA, EVERY_FRAME)
        recording.offer(odd)
        recording.offer(DepthFrame(float("nan"), 2, np.zeros((4, 4), np.uint16), 0.001, LENS))
        recording.close()
    assert (recorder.dropped, recorder.error) == (0, None)


@pytest.mark.parametrize("rate_hz", [1.0, 2.0, 4.0, 10.0])
def test_the_rate_is_kept_on_a_camera_that_is_not_punctual(rate_hz: float) -> None:
    random = np.random.default_rng(3)
    times = T0_S + np.arange(0.0, 10.0, 1 / 30) + random.uniform(0.0, 0.004, 300)
    pace = Pace(rate_hz)
    kept = [t_s for t_s in times.tolist() if pace.is_due(t_s)]
    assert len(kept) == pytest.approx(10 * rate_hz, abs=1)
    assert np.diff(kept).max() < 1 / rate_hz + 0.04


def test_every_frame_is_due_at_the_rate_of_an_unpunctual_camera() -> None:
    random = np.random.default_rng(4)
    pace = Pace(30.0)
    assert all(pace.is_due(T0_S + k / 30 + late_s) for k, late_s in enumerate(random.uniform(0.0, 0.008, 300).tolist()))


def test_a_clock_that_jumps_back_does_not_end_the_recording() -> None:
    pace = Pace(2.0)
    assert [pace.is_due(T0_S + t_s) for t_s in (0.0, -100.0, -99.9, -99.5)] == [True, True, False, True]


def test_images_that_the_disk_does_not_take_are_bounded_in_bytes_and_leave_room_for_the_rest(tmp_path: Path) -> None:
    gate, image = threading.Event(), depth.image_message(frames(1)[0], bytes(100_000))

    def is_accepted(message: object, topic: str = "/depth") -> bool:
        before = recorder.dropped
        recorder.log(topic, message, T0_S)
        return recorder.dropped == before

    recorder = Recorder(tmp_path / "p1.mcap", buffer_large_bytes=350_000, open_file=lambda path: GatedFile(path, gate))
    with recorder:
        assert [is_accepted(image) for _ in range(5)] == [True, True, True, False, False]
        assert is_accepted(own(T0_S), "/own")
        gate.set()
        wait_for(lambda: is_accepted(image))
    assert len(decoded(tmp_path / "p1.mcap", "/depth")) == 4


def test_depth_of_a_killed_process_is_readable_up_to_the_last_half_second(tmp_path: Path) -> None:
    path, output = tmp_path / "p1.mcap", tmp_path / "recovered.mcap"
    command = [sys.executable, "-m", "tests.recording.depth_writer_process", str(path)]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        offered = [float(process.stdout.readline()) for _ in range(40)]
        process.kill()
        offered += [float(line) for line in process.stdout.read().splitlines()]
    source = McapSource(path)
    played = []
    while (frame := source.latest()) is not None:
        played.append(frame)
    assert offered[-1] - 0.5 <= played[-1].t_s <= offered[-1] + 0.1
    assert "breaks off" in source.health.fault
    np.testing.assert_array_equal(played[-1].depth, np.full((LENS.height_px, LENS.width_px), played[-1].number, np.uint16))

    recover(path, output)
    recovered = McapSource(output)
    again = []
    while (frame := recovered.latest()) is not None:
        again.append(frame.number)
    assert again == [frame.number for frame in played]
    assert recovered.health.fault == ""

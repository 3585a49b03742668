"""Recorded flights as a source of depth frames; whatever else is named is refused in one sentence."""

from __future__ import annotations

import contextlib
import json
import shutil
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.writer import Writer
from numpy.typing import NDArray

from flightapp.core.types import VehicleState
from flightapp.recording import depth
from flightapp.recording.reader import discs_of, read_recording
from flightapp.recording.recorder import Recorder
from flightapp.runtime.depth_recording import DepthRecording, RecordedSource
from flightapp.vehicle.pose_history import PoseHistory
from perception.errors import PerceptionInputError
from perception.geometry import CameraMounting
from perception.parameters import PerceptionParameters
from perception.pipeline import PerceptionPipeline
from perception.sources import SourceHealth
from perception.sources.mcap import McapSource
from perception.types import DepthFrame, PerceivedObstacles, VehiclePose
from tests.perception.scenes import MOUNTING, MakeStage, pose
from tests.recording.depth_flight import CAMERA, EVERY_FRAME, LENS, expected_north_m, expected_yaw_rad, frames, history, record
from tests.recording.samples import T0_S, log_steps

FREELY = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
COUNT = 6


@pytest.fixture(scope="module")
def flight(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record(tmp_path_factory.mktemp("flight") / "p1.mcap", frames(COUNT), history())


def played(source: McapSource) -> list[DepthFrame]:
    shots = []
    while (frame := source.latest()) is not None:
        shots.append(frame)
    return shots


def altered(
    source: Path,
    target: Path,
    *,
    info: Callable[[int, dict[str, Any]], Any] = lambda k, content: content,
    image: Callable[[int, bytes], bytes] = lambda k, data: data,
    profile: str = "flightapp",
    image_schema: str = "foxglove.CompressedImage",
    leave_out: str = "",
) -> Path:
    """A copy of a recording with the k-th info and image changed."""
    with source.open("rb") as file, target.open("wb") as output:
        writer = Writer(output)
        writer.start(profile=profile)
        ids: dict[str, int] = {}
        counts: dict[str, int] = {}
        for schema, channel, message in make_reader(file).iter_messages(log_time_order=False):
            topic = channel.topic
            if topic == leave_out or schema is None:
                continue
            if topic not in ids:
                name = image_schema if topic == "/depth" else schema.name
                schema_id = writer.register_schema(name, schema.encoding, schema.data)
                ids[topic] = writer.register_channel(topic, channel.message_encoding, schema_id)
            k = counts[topic] = counts.get(topic, -1) + 1
            data = message.data
            if topic == "/depth/info":
                data = json.dumps(info(k, json.loads(data))).encode()
            elif topic == "/depth":
                data = image(k, data)
            writer.add_message(ids[topic], message.log_time, data, message.publish_time)
        writer.finish()  # type: ignore[no-untyped-call]
    return target


def test_a_recorded_flight_plays_as_it_was_seen(flight: Path) -> None:
    source, shots = McapSource(flight), frames(COUNT)
    assert not source.is_finished
    for k, shot in enumerate(shots):
        frame = source.latest()
        assert frame is not None
        np.testing.assert_array_equal(frame.depth, shot.depth)
        assert (frame.t_s, frame.number, frame.depth_unit_m) == (shot.t_s, shot.number, shot.depth_unit_m)
        assert frame.intrinsics == LENS
        assert frame.pose is not None
        assert frame.pose.position_ned_m == pytest.approx((expected_north_m(shot.t_s), 1.0, -5.0), abs=1e-6)
        assert frame.pose.velocity_ned_m_s == pytest.approx((2.0, 0.0, 0.0))
        assert frame.pose.yaw_rad == pytest.approx(expected_yaw_rad(shot.t_s), abs=1e-6)
        assert source.health == SourceHealth(received=k + 1)
    assert source.is_finished
    assert source.latest() is None
    assert source.camera.mounting == CameraMounting(0.12, -0.02, 0.03, 1.0, -10.0, 2.5)
    assert (source.camera.range_min_m, source.camera.range_max_m, source.camera.ground_down_m) == (0.3, 10.0, -1.5)
    source.close()


def test_frames_without_a_pose_have_none(tmp_path: Path) -> None:
    (frame,) = played(McapSource(record(tmp_path / "p1.mcap", frames(1), PoseHistory())))
    assert frame.pose is None


def test_a_closed_source_is_finished(flight: Path) -> None:
    source = McapSource(flight)
    source.close()
    assert source.is_finished
    assert source.latest() is None


def test_recorded_depth_gives_the_recorded_discs(tmp_path: Path, scene: MakeStage) -> None:
    """The flight: camera, its recording, perception and recorder as in the vehicle. The replay: the file alone."""
    stage = scene(cylinders=[(6.0, 0.8, 0.3, 8.0), (5.0, -1.5, 0.15, 8.0)], boxes=[(8.0, 3.0, 0.4, 3.0, 8.0, 20.0)])
    known, compressed = PoseHistory(), threading.Semaphore(0)

    def compress(pixels: NDArray[np.uint16]) -> bytes:
        compressed.release()
        return depth.png(pixels)

    class Flown:
        """A camera that is carried north, and the telemetry with it."""

        health, is_finished = SourceHealth(), False

        def latest(self) -> DepthFrame:
            k = stage.number
            at = pose(north=0.05 * k, yaw_deg=0.3 * k)
            shot = stage.shoot(at)
            t_s = T0_S + k / 30
            known.append_state(VehicleState(t_s, np.array(at.position_ned_m), np.array(at.velocity_ned_m_s), at.yaw_rad))
            known.append_attitude(t_s, at.roll_rad, at.pitch_rad, at.yaw_rad)
            return DepthFrame(t_s, shot.number, shot.depth, shot.depth_unit_m, shot.intrinsics)

        def close(self) -> None:
            """Nothing to give back."""

    camera = depth.DepthCamera(_recorded(MOUNTING), 0.3, 10.0, 0.0)
    with Recorder(tmp_path / "p1.mcap") as recorder:
        source = RecordedSource(Flown(), DepthRecording(recorder, known, camera, EVERY_FRAME, compress))
        perceiving = PerceptionPipeline(PerceptionParameters(), MOUNTING, range_min_m=0.3, range_max_m=10.0, ground_down_m=0.0)
        for _ in range(12):
            frame = source.latest()
            assert frame is not None
            motion = known.at(frame.t_s)
            assert motion is not None
            north, east, down = motion.state.position_ned_m.tolist()
            at = VehiclePose((north, east, down), (0.0, 0.0, 0.0), motion.roll_rad, motion.pitch_rad, motion.state.yaw_rad)
            recorder.log("/obstacles", _message(frame, perceiving.process(frame, at)), frame.t_s)
            assert compressed.acquire(timeout=10.0)
        source.close()

    told = read_recording(tmp_path / "p1.mcap").topic("/obstacles").messages
    again = McapSource(tmp_path / "p1.mcap")
    was = again.camera
    replaying = PerceptionPipeline(
        PerceptionParameters(),
        was.mounting,
        range_min_m=was.range_min_m,
        range_max_m=was.range_max_m,
        ground_down_m=was.ground_down_m,
    )
    shots = played(again)
    assert [shot.number for shot in shots] == [message["frame_number"] for message in told] == list(range(1, 13))
    for shot, message in zip(shots, told, strict=True):
        assert shot.pose is not None
        seen = replaying.process(shot, shot.pose)
        np.testing.assert_allclose(seen.discs, discs_of(message), rtol=0, atol=1e-9)
        np.testing.assert_allclose(seen.unseen, np.array(message["unseen_rad"]).reshape(-1, 2), rtol=0, atol=1e-9)
    assert len(discs_of(told[-1])) >= 3


def test_a_folder_with_one_recording_is_that_recording(tmp_path: Path, flight: Path) -> None:
    shutil.copy(flight, tmp_path / "p1.mcap")
    (tmp_path / "summary.json").write_text("{}")
    assert len(played(McapSource(tmp_path))) == COUNT


def test_a_run_folder_of_several_lists_what_to_choose_from(tmp_path: Path, flight: Path) -> None:
    for name in ("p1", "p2", "truth"):
        shutil.copy(flight, tmp_path / f"{name}.mcap")
    with pytest.raises(PerceptionInputError, match=r"several recordings; name one of p1\.mcap, p2\.mcap, truth\.mcap"):
        McapSource(tmp_path)
    with pytest.raises(PerceptionInputError, match=r"no p3\.mcap; name one of p1\.mcap, p2\.mcap"):
        McapSource(tmp_path, vehicle="p3")
    assert McapSource(tmp_path, vehicle="p1").path.name == "p1.mcap"


def test_the_recording_of_another_vehicle_is_named_as_such(flight: Path) -> None:
    with pytest.raises(PerceptionInputError, match="of vehicle 'p1', not of 'p2'"):
        McapSource(flight, vehicle="p2")


def test_a_recording_without_depth_says_how_to_record_it(tmp_path: Path) -> None:
    with Recorder(tmp_path / "p1.mcap") as recorder:
        log_steps(recorder, 5)
    with pytest.raises(PerceptionInputError, match=r"holds no depth frames on '/depth'; .*recording\.depth_rate_hz above 0"):
        McapSource(tmp_path / "p1.mcap")


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"", "the file is empty"),
        (b"\x00" * 4000, "does not begin like an MCAP file"),
        (b"\x89MCAP0\r\n", "broke off before its first record"),
        (b"# a text file", "does not begin like an MCAP file"),
    ],
)
def test_files_that_are_no_recordings(tmp_path: Path, content: bytes, sentence: str) -> None:
    (tmp_path / "x.mcap").write_bytes(content)
    with pytest.raises(PerceptionInputError, match=sentence):
        McapSource(tmp_path / "x.mcap")


def test_missing_files_and_empty_folders_are_named(tmp_path: Path) -> None:
    with pytest.raises(PerceptionInputError, match=r"none\.mcap: no such file or folder"):
        McapSource(tmp_path / "none.mcap")
    with pytest.raises(PerceptionInputError, match="holds no recording"):
        McapSource(tmp_path)


def test_a_foreign_mcap_file_is_named_as_such(tmp_path: Path, flight: Path) -> None:
    path = altered(flight, tmp_path / "x.mcap", profile="ros2")
    with pytest.raises(PerceptionInputError, match=r"not a recording of flightapp \(profile 'ros2', written by 'mcap"):
        McapSource(path)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"version": 2}, "of version 2, this program reads version 1"),
        ({"version": None}, "of version None"),
        ({"depth_unit_m": 0.0}, "depth_unit_m = 0.0 must be positive"),
        ({"t_s": float("nan")}, "t_s = nan is not a finite number"),
        ({"width_px": 30}, "its image has 87x49 pixels, not 30x49"),
        ({"position_ned_m": [1.0]}, "cannot be read"),
        ({"mounting": None}, "cannot be read"),
        ({"mounting": {}}, "lacks the field 'forward_m'"),
    ],
)
def test_what_a_newer_or_broken_program_wrote_is_one_sentence(
    tmp_path: Path, flight: Path, change: dict[str, object], sentence: str
) -> None:
    path = altered(flight, tmp_path / "x.mcap", info=lambda _, content: {**content, **change})
    with pytest.raises(PerceptionInputError, match=sentence) as raised:
        McapSource(path)
    assert str(raised.value).startswith(str(path))


@pytest.mark.parametrize("content", [None, [], "text", 3, {}])
def test_an_info_that_is_no_object_is_one_sentence(tmp_path: Path, flight: Path, content: object) -> None:
    with pytest.raises(PerceptionInputError, match="damaged"):
        McapSource(altered(flight, tmp_path / "x.mcap", info=lambda _, __: content))


def test_another_kind_of_image_is_one_sentence(tmp_path: Path, flight: Path) -> None:
    path = altered(flight, tmp_path / "x.mcap", image_schema="foxglove.RawImage")
    with pytest.raises(PerceptionInputError, match=r"holds foxglove\.RawImage in protobuf; foxglove\.CompressedImage"):
        McapSource(path)


def test_images_alone_are_not_enough(tmp_path: Path, flight: Path) -> None:
    path = altered(flight, tmp_path / "x.mcap", leave_out="/depth/info")
    with pytest.raises(PerceptionInputError, match="no '/depth/info' beside them"):
        McapSource(path)


def test_a_damaged_frame_is_left_out_and_told(tmp_path: Path, flight: Path) -> None:
    path = altered(flight, tmp_path / "x.mcap", image=lambda k, data: data[:-400] if k == 2 else data)
    source = McapSource(path)
    numbers, faults = [], []
    while (frame := source.latest()) is not None:
        numbers.append(frame.number)
        faults.append(source.health.fault)
    assert numbers == [100, 101, 103, 104, 105]
    assert source.health.lost == 1
    assert "damaged" in faults[1]  # told once, between the frames where the damaged one was
    assert [bool(fault) for fault in faults] == [False, True, False, False, False]


def test_what_is_left_of_a_cut_file_is_played(tmp_path: Path, flight: Path) -> None:
    (tmp_path / "x.mcap").write_bytes(_without_its_end(flight))
    source = McapSource(tmp_path / "x.mcap")
    shots = played(source)
    assert [shot.number for shot in shots] == list(range(100, 100 + len(shots)))
    assert 0 < len(shots) < COUNT
    assert f"breaks off after {len(shots)} depth frames" in source.health.fault
    assert source.is_finished


@FREELY
@given(share=st.floats(0.0, 1.0))
def test_truncation_anywhere(tmp_path: Path, flight: Path, share: float) -> None:
    _plays_or_says_why(tmp_path / "x.mcap", flight.read_bytes()[: int(share * flight.stat().st_size)])


@FREELY
@given(data=st.data())
def test_damage_anywhere(tmp_path: Path, flight: Path, data: st.DataObject) -> None:
    damaged = bytearray(flight.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        start = data.draw(st.integers(0, len(damaged) - 1))
        damaged[start : start + data.draw(st.integers(0, 8))] = data.draw(st.binary(max_size=8))
    _plays_or_says_why(tmp_path / "x.mcap", bytes(damaged))


def _plays_or_says_why(path: Path, content: bytes) -> None:
    """Frames come to the bit, or one sentence; nothing in between."""
    path.write_bytes(content)
    true = {shot.number: shot.depth for shot in frames(COUNT)}
    with contextlib.suppress(PerceptionInputError), contextlib.closing(McapSource(path)) as source:
        for shot in played(source):
            np.testing.assert_array_equal(shot.depth, true[shot.number])


def _without_its_end(path: Path) -> bytes:
    """Cut inside the last third of the file's chunks."""
    content = path.read_bytes()
    return content[: len(content) * 2 // 3]


def _recorded(mounting: CameraMounting) -> Any:
    return type(CAMERA.mounting)(
        mounting.forward_m, mounting.right_m, mounting.down_m, mounting.roll_deg, mounting.pitch_deg, mounting.yaw_deg
    )


def _message(frame: DepthFrame, seen: PerceivedObstacles) -> dict[str, object]:
    """As the journal writes it, the infinite heights null."""
    rows = [[value if np.isfinite(value) else None for value in row] for row in seen.discs.tolist()]
    return {"frame_number": frame.number, "discs": rows, "unseen_rad": seen.unseen.tolist()}

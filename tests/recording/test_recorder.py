"""The recorder: what goes in comes out, and whatever the disk does the caller does not notice."""

from __future__ import annotations

import errno
import io
import threading
import time
from collections.abc import Callable
from pathlib import Path

import foxglove.messages as fx
import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from flightapp.analysis.run import load_run
from flightapp.config.mission import load_mission
from flightapp.core.errors import InputError
from flightapp.recording import messages
from flightapp.recording.channels import CHANNELS, Channel, Priority
from flightapp.recording.reader import discs_of, read_recording
from flightapp.recording.recorder import Recorder
from flightapp.recording.sink import create_file
from tests.recording.samples import T0_S, event, log_steps, obstacles, own, target

MISSION = Path(__file__).resolve().parents[2] / "missions" / "demo_two_pursuers.toml"


def wait_for(condition: Callable[[], bool], deadline_s: float = 5.0) -> None:
    end = time.monotonic() + deadline_s
    while not condition():
        assert time.monotonic() < end, "the condition did not come true in time"
        time.sleep(0.005)


class GatedFile(io.FileIO):
    """A disk that takes nothing until the gate opens."""

    def __init__(self, path: Path, gate: threading.Event) -> None:
        super().__init__(path, "xb")
        self.gate = gate
        self.waiting = threading.Event()

    def write(self, data: object) -> int:
        self.waiting.set()
        assert self.gate.wait(20.0)
        return super().write(data)  # type: ignore[arg-type]


class FullFile(io.FileIO):
    """A disk with room for `room` bytes."""

    def __init__(self, path: Path, room: int) -> None:
        super().__init__(path, "xb")
        self.room = room

    def write(self, data: object) -> int:
        size = len(bytes(data))  # type: ignore[call-overload]
        if self.room < size:
            raise OSError(errno.ENOSPC, "No space left on device")
        self.room -= size
        return super().write(data)  # type: ignore[arg-type]


def test_what_is_logged_is_read_back(tmp_path: Path) -> None:
    path = tmp_path / "p1.mcap"
    with Recorder(path) as recorder:
        recorder.metadata("run", {"vehicle": "p9", "seed": 4})
        recorder.attach("mission.toml", MISSION)
        log_steps(recorder, 50)
        recorder.log("/event", event(T0_S), T0_S)
    recording = read_recording(path)
    assert recording.complete
    assert recorder.dropped == 0
    assert recorder.error is None
    assert recording.vehicle == "p9"
    assert recording.metadata["run"]["seed"] == "4"
    assert recording.attachments["mission.toml"] == MISSION.read_bytes()
    series = recording.topic("/own")
    np.testing.assert_allclose(series.t_s, T0_S + np.arange(50) / 25.0, atol=1e-6)
    np.testing.assert_array_equal(series.vectors("position_ned_m")[:, 0], np.arange(50))
    assert recording.topic("/event").messages[0]["data"] == {"age_s": 0.7}
    assert len(recording.topic("/team")) == 0


def test_unknown_heights_survive_as_infinities(tmp_path: Path) -> None:
    with Recorder(tmp_path / "p1.mcap") as recorder:
        recorder.log("/obstacles", obstacles(T0_S), T0_S)
    discs = discs_of(read_recording(tmp_path / "p1.mcap").topic("/obstacles").messages[0])
    np.testing.assert_array_equal(discs[:, 5:], [[-np.inf, np.inf], [-9.0, 0.0]])


def test_numpy_and_odd_values_are_recorded(tmp_path: Path) -> None:
    decision = messages.DecisionRecord(
        T0_S, [0.0, 0.0, 0.0], 0.0, "m", None, "", 0.0, {"cost": np.float64(2.5), "row": np.arange(6.0)[::2], 3: object}
    )
    with Recorder(tmp_path / "p1.mcap") as recorder:
        recorder.log("/decision", decision, T0_S)
    diagnostics = read_recording(tmp_path / "p1.mcap").topic("/decision").messages[0]["diagnostics"]
    assert diagnostics == {"cost": 2.5, "row": [0.0, 2.0, 4.0], "3": "<class 'object'>"}


def test_foxglove_views_are_derived(tmp_path: Path) -> None:
    path = tmp_path / "p1.mcap"
    with Recorder(path, mission=load_mission(MISSION)) as recorder:
        log_steps(recorder, 50)
        recorder.log("/event", event(T0_S + 1.0), T0_S + 1.0)
    with path.open("rb") as file:
        found: dict[str, list[object]] = {}
        for schema, channel, _, content in make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages(
            topics=["/view/pose", "/view/scene", "/log"]
        ):
            found.setdefault(f"{channel.topic} {schema.name}", []).append(content)
    assert 15 <= len(found["/view/pose foxglove.PoseInFrame"]) <= 20
    assert 8 <= len(found["/view/scene foxglove.SceneUpdate"]) <= 10
    pose = found["/view/pose foxglove.PoseInFrame"][0].pose  # type: ignore[attr-defined]
    assert (pose.position.x, pose.position.y, pose.position.z) == (1.0, 0.0, 5.0)  # east, north, up
    scenes = [{entity.id: entity for entity in scene.entities} for scene in found["/view/scene foxglove.SceneUpdate"]]  # type: ignore[attr-defined]
    assert len(scenes[0]["mission"].cylinders) == 7
    assert len(scenes[0]["mission"].lines) == 2
    assert set(scenes[1]) == {"discs", "target"}
    assert found["/log foxglove.Log"][0].level == 3  # type: ignore[attr-defined]


def test_an_unknown_topic_is_refused_at_start_and_counted_in_flight(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "p1.mcap")
    recorder.require(["/own", "/event"])
    with pytest.raises(ValueError, match="not recorded channels: /owm"):
        recorder.require(["/owm"])
    with recorder:
        recorder.log("/owm", own(T0_S), T0_S)
    assert recorder.dropped == 1


def test_a_topic_twice_is_refused() -> None:
    with pytest.raises(ValueError, match="occurs twice"):
        Recorder(Path("x.mcap"), channels=(*CHANNELS, CHANNELS[0]))


def test_channels_that_are_not_logged_are_not_in_the_file(tmp_path: Path) -> None:
    events = next(channel for channel in CHANNELS if channel.topic == "/event")
    channels = (Channel("/own", messages.OwnState, 25.0, Priority.STATE, 0.0, "live only", logged=False), events)
    with Recorder(tmp_path / "p1.mcap", channels=channels) as recorder:
        recorder.log("/own", own(T0_S), T0_S)
        recorder.log("/event", event(T0_S), T0_S)
    assert recorder.dropped == 0
    assert set(read_recording(tmp_path / "p1.mcap").series) == {"/event"}


@pytest.mark.parametrize("value", ["\ud800", 1 << 70])
def test_a_message_that_cannot_be_serialised_never_raises(tmp_path: Path, value: object) -> None:
    with Recorder(tmp_path / "p1.mcap") as recorder:
        recorder.log("/event", messages.Event(T0_S, "info", "x", "y", {"value": value}), T0_S)
        recorder.log("/own", own(T0_S), float("nan"))
        recorder.log("/own", own(T0_S), -1.0)
        log_steps(recorder, 5)
    assert recorder.dropped == 3
    assert recorder.error is None
    assert len(read_recording(tmp_path / "p1.mcap").topic("/own")) == 5


def test_a_message_that_cannot_be_drawn_is_recorded_all_the_same(tmp_path: Path) -> None:
    with Recorder(tmp_path / "p1.mcap") as recorder:
        recorder.log("/own", messages.OwnState(T0_S, [], [], 0.0, 0.0, 0.0, 0.0), T0_S)
        log_steps(recorder, 5)
    assert (recorder.dropped, recorder.error) == (0, None)
    assert len(read_recording(tmp_path / "p1.mcap").topic("/own")) == 6


def test_a_disk_that_hangs_costs_messages_not_time(tmp_path: Path) -> None:
    gate = threading.Event()
    files: list[GatedFile] = []

    def open_gated(path: Path) -> GatedFile:
        files.append(GatedFile(path, gate))
        return files[0]

    path = tmp_path / "p1.mcap"
    recorder = Recorder(path, buffer_messages=100, open_file=open_gated)
    recorder.open()
    assert files[0].waiting.wait(5.0)  # the recorder's thread is inside a write that does not return
    for step in range(500):
        t_s = T0_S + step * 0.04
        recorder.log("/own", own(t_s), t_s)
        recorder.log("/target", target(t_s), t_s)
        if step % 50 == 0:
            recorder.log("/event", event(t_s), t_s)
    assert not gate.is_set()  # everything returned while the disk hung
    drops = recorder.drops
    gate.set()
    recorder.close()
    recording = read_recording(path)
    assert recording.complete
    counts = {topic: len(recording.topic(topic)) for topic in ("/own", "/target")}
    assert counts == {"/own": 500 - drops["/own"], "/target": 500 - drops["/target"]}
    assert sum(counts.values()) + 10 - drops.get("/event", 0) <= 100
    assert drops["/target"] > drops["/own"] > 0
    assert "/event" not in drops  # the dearest have room to the last
    told = recording.topic("/event").messages[-1]
    assert (told["name"], told["data"]["channels"]["/own"]) == ("recording-dropped", drops["/own"])
    assert recording.metadata["recording"]["dropped"] == str(recorder.dropped)
    assert recording.metadata["recording"]["dropped /own"] == str(drops["/own"])


def test_a_disk_that_gets_full_loses_the_cheapest_channels_first(tmp_path: Path) -> None:
    free = {"bytes": 10**12}
    path = tmp_path / "p1.mcap"
    with Recorder(path, free_bytes=lambda _: free["bytes"]) as recorder:

        def logs(topic: str, message: object) -> bool:
            before = recorder.dropped
            recorder.log(topic, message, T0_S)
            return recorder.dropped == before

        image = fx.CompressedImage(data=b"0" * 100, format="png")
        offers = {"/depth": image, "/target": target(T0_S), "/own": own(T0_S), "/event": event(T0_S)}
        for room, kept in (
            (900_000_000, ["/target", "/own", "/event"]),
            (90_000_000, ["/own", "/event"]),
            (10_000_000, ["/event"]),
            (2_000_000_000, ["/depth", "/target", "/own", "/event"]),
        ):
            free["bytes"] = room
            wait_for(lambda kept=kept: [topic for topic, message in offers.items() if logs(topic, message)] == kept)
    assert recorder.error is None
    assert read_recording(path).metadata["recording"]["dropped /depth"] == str(recorder.drops["/depth"])


def test_the_slowest_flush_is_known(tmp_path: Path) -> None:
    class SlowFile(io.FileIO):
        def flush(self) -> None:
            time.sleep(0.3)
            super().flush()

    with Recorder(tmp_path / "p1.mcap", open_file=lambda path: SlowFile(path, "xb")) as recorder:
        wait_for(lambda: recorder.flush_slowest_s >= 0.3)


def test_the_small_log_has_all_events_and_few_states(tmp_path: Path) -> None:
    path, small = tmp_path / "p1.mcap", tmp_path / "p1.small.mcap"
    with Recorder(path, small_path=small) as recorder:
        recorder.metadata("run", {"vehicle": "p1"})
        recorder.attach("mission.toml", MISSION)
        log_steps(recorder, 500)
        for step in range(100):
            recorder.log("/event", event(T0_S + step * 0.2), T0_S + step * 0.2)
    recording = read_recording(small)
    assert recording.complete
    assert recording.vehicle == "p1"
    assert recording.attachments["mission.toml"] == MISSION.read_bytes()
    assert recording.topic("/event").messages == read_recording(path).topic("/event").messages
    assert 38 <= len(recording.topic("/own")) <= 42  # 20 s at 2 Hz
    assert 9 <= len(recording.topic("/obstacles")) <= 11
    assert small.stat().st_size < 0.3 * path.stat().st_size
    run = load_run([tmp_path])
    assert ([vehicle.recording.path for vehicle in run.vehicles], run.unreadable) == ([path], ())
    assert [vehicle.recording.path for vehicle in load_run([small]).vehicles] == [small]


def test_a_small_log_without_room_ends_alone(tmp_path: Path) -> None:
    path, small = tmp_path / "p1.mcap", tmp_path / "p1.small.mcap"

    def open_file(path: Path) -> io.FileIO:
        return FullFile(path, 100) if path == small else FullFile(path, 10**9)

    with Recorder(path, small_path=small, open_file=open_file) as recorder:
        log_steps(recorder, 20)
        wait_for(lambda: recorder._small is None and recorder._thread is not None and recorder.flush_slowest_s > 0.0)
    assert recorder.error is None
    assert len(read_recording(path).topic("/own")) == 20


def test_messages_are_made_in_the_recorders_thread(tmp_path: Path) -> None:
    makers: list[str] = []

    def make() -> messages.OwnState:
        makers.append(threading.current_thread().name)
        return own(T0_S)

    def fail() -> messages.OwnState:
        raise ValueError("no state")

    with Recorder(tmp_path / "p1.mcap") as recorder:
        recorder.log("/own", make, T0_S)
        recorder.log("/own", fail, T0_S)
    assert makers == ["recorder"]
    assert recorder.drops == {"/own": 1}
    assert len(read_recording(tmp_path / "p1.mcap").topic("/own")) == 1


def test_closing_gives_up_on_a_disk_that_never_returns(tmp_path: Path) -> None:
    gate = threading.Event()
    recorder = Recorder(tmp_path / "p1.mcap", open_file=lambda path: GatedFile(path, gate))
    recorder.open()
    log_steps(recorder, 10)
    recorder.close(timeout_s=0.1)
    assert recorder.error is not None
    assert "within 0.1 s" in recorder.error
    gate.set()


@pytest.mark.parametrize("room", [0, 20_000])
def test_a_full_disk_ends_the_recording_and_nothing_else(tmp_path: Path, room: int) -> None:
    path = tmp_path / "p1.mcap"
    recorder = Recorder(path, open_file=lambda path: FullFile(path, room))
    recorder.open()

    def failed() -> bool:
        log_steps(recorder, 20)
        return recorder.error is not None

    wait_for(failed)
    assert recorder.error == f"{path}: recording stopped: No space left on device"
    dropped = recorder.dropped
    log_steps(recorder, 10)
    assert recorder.dropped == dropped + 30
    recorder.close()
    if room:
        recording = read_recording(path)
        assert not recording.complete
        assert len(recording.topic("/own")) > 0


def test_an_existing_file_is_never_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "p1.mcap"
    path.write_bytes(b"precious")
    with pytest.raises(InputError, match="exists already"):
        Recorder(path).open()
    assert path.read_bytes() == b"precious"


def test_a_folder_that_cannot_be_made_is_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"cannot be recorded to|exists already"):
        Recorder(tmp_path / "file" / "p1.mcap").open()


def test_an_attachment_that_is_missing_is_one_sentence(tmp_path: Path) -> None:
    with Recorder(tmp_path / "p1.mcap") as recorder, pytest.raises(InputError, match="cannot be attached"):
        recorder.attach("profile.toml", tmp_path / "none.toml")


def test_a_new_file_gets_its_folder(tmp_path: Path) -> None:
    with create_file(tmp_path / "a" / "b" / "c.mcap") as file:
        assert file.writable()

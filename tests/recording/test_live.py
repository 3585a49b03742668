"""The live view: the topics and bytes of the recording, over a WebSocket, to a client that speaks Foxglove's protocol."""

from __future__ import annotations

import contextlib
import socket
import time
from pathlib import Path

import pytest
from mcap.reader import make_reader

from flightapp.config.mission import load_mission
from flightapp.core.errors import InputError
from flightapp.recording.channels import CHANNELS
from flightapp.recording.live import LiveView, url_file, url_told
from flightapp.recording.recorder import Recorder
from tests.recording.live_client import LiveClient
from tests.recording.samples import T0_S, event, log_steps

MISSION = Path(__file__).resolve().parents[2] / "missions" / "demo_two_pursuers.toml"
STEPS = 25
SEEN = {"/own", "/obstacles", "/target", "/event", "/log", "/view/pose", "/view/location", "/view/scene"}


def test_a_client_gets_what_the_file_gets(tmp_path: Path) -> None:
    path = tmp_path / "p1.mcap"
    received: dict[str, list[tuple[int, bytes]]] = {}
    with Recorder(path, mission=load_mission(MISSION), live=LiveView(port=0)) as recorder:
        assert recorder.live_url is not None
        with LiveClient(recorder.live_url) as client:
            live = {channel.topic for channel in CHANNELS if channel.live}
            client.advertised(live)
            assert set(client.channels) == live
            assert client.server["name"] == "p1"
            client.subscribe()
            step = 0
            while not {"/event", "/log"} <= set(received):  # until the subscriptions have reached the server
                assert step < 100
                recorder.log("/event", event(T0_S + step), T0_S + step)
                with contextlib.suppress(TimeoutError):
                    topic, time_ns, data = client.message(timeout_s=0.2)
                    received.setdefault(topic, []).append((time_ns, data))
                step += 1
            log_steps(recorder, STEPS)
            while len(received.get("/target", [])) < STEPS or not set(received) >= SEEN:
                topic, time_ns, data = client.message()
                received.setdefault(topic, []).append((time_ns, data))
            offered = client.channels
    assert recorder.dropped == 0
    filed: dict[str, list[tuple[int, bytes]]] = {}
    with path.open("rb") as file:
        reader = make_reader(file)
        for schema, channel, message in reader.iter_messages():
            filed.setdefault(channel.topic, []).append((message.log_time, message.data))
            assert schema is not None
            assert (offered[channel.topic]["schemaName"], offered[channel.topic]["encoding"]) == (
                schema.name,
                channel.message_encoding,
            )
    assert set(filed) == set(received)
    for topic, messages in received.items():
        assert set(messages) <= set(filed[topic])
    assert set(filed["/target"]) == set(received["/target"])


def test_it_is_bound_to_this_machine_unless_told_otherwise(tmp_path: Path) -> None:
    with Recorder(tmp_path / "p1.mcap", live=LiveView(port=0)) as recorder:
        assert recorder.live_url is not None
        assert recorder.live_url.startswith("ws://127.0.0.1:")


def test_a_port_in_use_is_one_sentence_and_leaves_no_file(tmp_path: Path) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(InputError, match=f"--live: 127.0.0.1:{port}: cannot be served"):
            Recorder(tmp_path / "p1.mcap", live=LiveView(port=port)).open()
    assert list(tmp_path.iterdir()) == []


def test_the_port_is_free_again_after_the_flight(tmp_path: Path) -> None:
    with Recorder(tmp_path / "p1.mcap", live=LiveView(port=0)) as recorder:
        assert recorder.live_url is not None
        port = int(recorder.live_url.rpartition(":")[2])
    deadline_s = time.monotonic() + 5.0
    while True:
        try:
            with socket.create_connection(("127.0.0.1", port), timeout=0.2):
                pass
        except OSError:
            return
        assert time.monotonic() < deadline_s


def test_a_client_that_never_reads_costs_nothing(tmp_path: Path) -> None:
    with Recorder(tmp_path / "p1.mcap", live=LiveView(port=0), buffer_messages=100_000) as recorder:
        assert recorder.live_url is not None
        with LiveClient(recorder.live_url) as client:
            client.advertised({"/own"})
            client.subscribe()
            log_steps(recorder, 2000)
    assert (recorder.dropped, recorder.error) == (0, None)


def test_the_address_is_told_while_it_is_served(tmp_path: Path) -> None:
    with url_told(tmp_path, "p1", "ws://127.0.0.1:1234"):
        assert url_file(tmp_path, "p1").read_text().strip() == "ws://127.0.0.1:1234"
    assert list(tmp_path.iterdir()) == []

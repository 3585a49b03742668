"""The layout that opens a recording in Foxglove or Lichtblick names only what recordings have."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import orjson
import pytest
from mcap.reader import make_reader

from flightapp.config.mission import load_mission
from flightapp.recording import drawing, messages
from flightapp.recording.channels import CHANNELS
from flightapp.recording.recorder import Recorder
from tests.recording.samples import T0_S, event, log_steps

ROOT = Path(__file__).resolve().parents[2]
LAYOUT = json.loads((ROOT / "tools" / "foxglove-layout.json").read_text())
PANELS = {
    "3D": {"foxglove.PoseInFrame", "foxglove.PosesInFrame", "foxglove.SceneUpdate"},
    "map": {"foxglove.LocationFix"},
    "RosOut": {"foxglove.Log"},
}
"""Kinds of panel, and the schemas that each can show."""


def panels(kind: str) -> list[dict[str, Any]]:
    return [panel for name, panel in LAYOUT["configById"].items() if name.partition("!")[0] == kind]


def paths() -> Iterator[str]:
    """Every message path of plots and state transitions: /topic.field.field[0]."""
    for kind in ("Plot", "StateTransitions"):
        for panel in panels(kind):
            yield from (series["value"] for series in panel["paths"])


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, str], dict[str, Any]]:
    """Schema name of each topic, and the newest message of each that is JSON, of a recording with everything in it."""
    path = tmp_path_factory.mktemp("layout") / "p1.mcap"
    vector = [1.0, 0.0, -5.0]
    diagnostics: dict[str, object] = {"target_distance_m": 4.0, "eta_s": 2.0, "stage": "fine"}
    with Recorder(path, mission=load_mission(ROOT / "missions" / "demo_two_pursuers.toml")) as recorder:

        def log(topic: str, message: object) -> None:
            recorder.log(topic, message, T0_S + 2.0)

        log_steps(recorder, 25)
        log("/event", event(T0_S))
        log("/phase", messages.Phase(T0_S, "pursue", "", None))
        log("/decision", messages.DecisionRecord(T0_S, vector, 0.0, "fine", vector, "", 0.003, diagnostics))
        log("/setpoint", messages.SetpointRecord(T0_S, vector, 0.0, T0_S, True, [["fence", "near"]], 1.2))
        log("/health", messages.Health(T0_S, 0.3, 150.0, 1.0, 0, 4, 40.0, 41.0, 42.0))
        log("/autopilot", messages.AutopilotStatus(T0_S, True, "OFFBOARD", True, "IN_AIR", 0.1))
        log("/battery", messages.Battery(T0_S, 15.2, 0.7))
        log("/team", messages.Team(T0_S, [messages.Teammate("p2", "pursuer", vector, vector, "fine", "pursue", 1.0, 0.05, 0)]))
    schemas: dict[str, str] = {}
    newest: dict[str, Any] = {}
    with path.open("rb") as file:
        reader = make_reader(file)
        for schema, channel, message in reader.iter_messages():
            assert schema is not None
            schemas[channel.topic] = schema.name
            if channel.message_encoding == "json":
                newest[channel.topic] = orjson.loads(message.data)
    return schemas, newest


def test_every_panel_stands_in_the_arrangement() -> None:
    def names(node: object) -> set[str]:
        if isinstance(node, str):
            return {node}
        assert isinstance(node, dict)
        return names(node["first"]) | names(node["second"])

    assert names(LAYOUT["layout"]) == set(LAYOUT["configById"])
    kinds = {name.partition("!")[0] for name in LAYOUT["configById"]}
    assert kinds == {"3D", "map", "Plot", "StateTransitions", "RosOut"}


@pytest.mark.parametrize("path", list(paths()))
def test_every_plotted_value_is_recorded(path: str, recorded: tuple[dict[str, str], dict[str, Any]]) -> None:
    topic, *fields = path.split(".")
    value = recorded[1][topic]
    for field in fields:
        name, _, rest = field.partition("[")
        value = value[name]
        for index in re.findall(r"(\d+)\]", rest):
            value = value[int(index)]
    assert isinstance(value, (int, float, str)), f"{path} is {value!r}"


def test_every_shown_topic_has_a_schema_that_its_panel_shows(recorded: tuple[dict[str, str], dict[str, Any]]) -> None:
    shown = 0
    for kind, schemas in PANELS.items():
        for panel in panels(kind):
            topics = [panel["topicToRender"]] if kind == "RosOut" else list(panel["topics"])
            for topic in topics:
                assert recorded[0][topic] in schemas
                shown += 1
    assert shown == 5
    assert panels("3D")[0]["followTf"] == drawing.FRAME


def test_what_the_layout_shows_is_live_too() -> None:
    live = {channel.topic for channel in CHANNELS if channel.live}
    assert {path.partition(".")[0] for path in paths()} <= live

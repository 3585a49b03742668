"""What Foxglove shows: every drawn thing at its place, in Foxglove's frame."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import foxglove.messages as fx
import numpy as np
import orjson
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from flightapp.config.mission import load_mission
from flightapp.recording import messages
from flightapp.recording.channels import CHANNELS
from flightapp.recording.recorder import Recorder
from flightapp.recording.view import View
from tests.recording.samples import T0_S, own

MISSION = load_mission(Path(__file__).resolve().parents[2] / "missions" / "demo_two_pursuers.toml")
HEIGHT_M = MISSION.height_m


def candidates() -> messages.Candidates:
    """Straight on, a quarter turn to the right within the horizon, and one that collides, with the own course east."""
    return messages.Candidates(
        T0_S, 10.0, 1.0, -5.0, math.pi / 2, 1.0, [2.0, 2.0, 2.0], [0.0, math.pi / 2, 0.5], [0.5, 0.8, 0.0], [0, 0, 1], 1
    )


def decision() -> messages.DecisionRecord:
    found: dict[str, object] = {"circles": [[20.0, 5.0, 3.0]], "game_point": [18.0, 4.0]}
    return messages.DecisionRecord(T0_S, [1.0, 0.0, 0.0], 0.0, "coarse", [15.0, 2.0, 0.0], "", 0.001, found)


def team() -> messages.Team:
    return messages.Team(
        T0_S, [messages.Teammate("p2", "pursuer", [3.0, 4.0, -5.0], [0.0, 2.0, 0.0], "coarse", "pursue", 1.0, 0.1, 0)]
    )


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Any]]:
    """All messages of the view, by topic."""
    path = tmp_path_factory.mktemp("view") / "p1.mcap"
    with Recorder(path, mission=MISSION) as recorder:
        recorder.log("/team", team(), T0_S)
        recorder.log("/decision", decision(), T0_S)
        recorder.log("/candidates", candidates(), T0_S)
        for step in range(150):
            t_s = T0_S + step / 25.0
            recorder.log("/own", own(t_s), t_s)
    found: dict[str, list[Any]] = {}
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, _, content in reader.iter_decoded_messages(["/view/team", "/view/location", "/view/scene"]):
            found.setdefault(channel.topic, []).append(content)
    assert recorder.dropped == 0
    return found


def entity(drawn: dict[str, list[Any]], name: str) -> Any:
    return next(one for scene in drawn["/view/scene"] for one in scene.entities if one.id == name)


def test_apollonius_circles_goal_and_game_point_stand_where_the_planner_sees_them(drawn: dict[str, list[Any]]) -> None:
    intent = entity(drawn, "intent")
    points = np.array([(point.x, point.y, point.z) for point in intent.lines[0].points])
    np.testing.assert_allclose(np.hypot(points[:, 0] - 5.0, points[:, 1] - 20.0), 3.0)
    np.testing.assert_allclose(points[:, 2], HEIGHT_M)
    places = [(ball.pose.position.x, ball.pose.position.y) for ball in intent.spheres]
    assert places == [(2.0, 15.0), (4.0, 18.0)]


def test_candidate_paths_are_the_arcs_that_were_weighed(drawn: dict[str, list[Any]]) -> None:
    straight, turning, colliding = entity(drawn, "paths").lines
    end = straight.points[-1]
    assert (end.x, end.y, end.z) == pytest.approx((3.0, 10.0, 5.0))  # 2 m east
    radius_m = 2.0 / (math.pi / 2)
    end = turning.points[-1]
    assert (end.x, end.y) == pytest.approx((1.0 + radius_m, 10.0 - radius_m))  # east, then to the right: south
    assert turning.thickness > straight.thickness  # the chosen one
    assert colliding.color.r > colliding.color.g
    assert straight.color.g > straight.color.b


def test_paths_vanish_when_nothing_is_searched_any_more(drawn: dict[str, list[Any]]) -> None:
    paths = [len(one.lines) for scene in drawn["/view/scene"] for one in scene.entities if one.id == "paths"]
    assert paths == [3, 0]


def test_teammates_have_pose_place_and_name(drawn: dict[str, list[Any]]) -> None:
    shown = entity(drawn, "team")
    assert [text.text for text in shown.texts] == ["p2"]
    pose = drawn["/view/team"][0].poses[0]
    assert (pose.position.x, pose.position.y, pose.position.z) == (4.0, 3.0, 5.0)
    assert (pose.orientation.z, pose.orientation.w) == pytest.approx((0.0, 1.0))  # flies east


def test_fence_and_boundary_come_again_for_whoever_connects_later(drawn: dict[str, list[Any]]) -> None:
    times = [one.timestamp for scene in drawn["/view/scene"] for one in scene.entities if one.id == "mission"]
    assert len(times) == 2  # in 6 s


def test_the_place_on_the_globe_is_the_missions(drawn: dict[str, list[Any]]) -> None:
    fix = drawn["/view/location"][0]
    assert fix.latitude == pytest.approx(MISSION.datum.latitude_deg, abs=1e-7)
    assert fix.altitude == pytest.approx(MISSION.datum.altitude_m + 5.0)


def test_what_is_not_wanted_is_not_drawn() -> None:
    asked: list[str] = []

    def refuse(topic: str) -> bool:
        asked.append(topic)
        return False

    def fail(topic: str, message: object, time_ns: int) -> None:
        raise AssertionError(f"{topic} was drawn")

    View(fail, refuse, MISSION).feed("/own", orjson.dumps(own(T0_S)), int(T0_S * 1e9))
    assert set(asked) == {"/view/pose", "/view/location", "/view/scene"}


def test_well_known_schemas_keep_their_names() -> None:
    names = {channel.topic: channel.message.get_schema().name for channel in CHANNELS if hasattr(channel.message, "get_schema")}
    assert names["/view/scene"] == "foxglove.SceneUpdate"
    assert names["/log"] == "foxglove.Log"
    assert all(name.startswith("foxglove.") for name in names.values())
    assert fx.PoseInFrame.get_schema().name == names["/view/pose"]

"""The way home around what is known, flown by the whole application on the virtual clock."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from flightapp.config.mission import load_mission
from flightapp.core.errors import InputError
from flightapp.recording.reader import read_recording
from flightapp.runtime.control_loop import Guidance
from flightapp.runtime.outcome import Outcome
from flightapp.runtime.way_home import WayHome
from flightapp.runtime.way_planner import shape_of
from flightapp.sim.autopilot_modes import Mode
from flightapp.sim.virtual.fleet import VirtualFleet
from flightapp.sim.virtual.mission import fly_virtual
from flightapp.space.world import World

ROOT = Path(__file__).parents[3]
SIM = ROOT / "profiles/sim.toml"
MISSION = Path(__file__).with_name("behind_a_block.toml")
BODY_AND_MARGIN_M = 0.8


class Homeward:
    """Where the vehicle was while it returned."""

    def __init__(self) -> None:
        self.places: list[np.ndarray] = []

    def __call__(self, fleet: VirtualFleet) -> None:
        one = fleet.vehicles["e1"]
        if one.loop.phase == "return" and one.is_flying:
            self.places.append(one.position_ned_m)


def flown(path: Path, run: Path) -> tuple[VirtualFleet, np.ndarray, list[str]]:
    run.mkdir()
    seen = Homeward()
    fleet = fly_virtual(path, SIM, run, seed=1, watch=seen)
    events = read_recording(run / "e1.mcap").topic("/event")
    texts = [text for name, text in zip(events.texts("name"), events.texts("text"), strict=True) if name == "way_home"]
    return fleet, np.array(seen.places), texts


def test_it_flies_home_around_a_block_and_lands_at_its_start(tmp_path: Path) -> None:
    fleet, places, texts = flown(MISSION, tmp_path / "run")
    one = fleet.vehicles["e1"]
    assert one.outcome is Outcome.TIMEOUT, one.error
    assert not one.station.core.armed
    assert math.dist(one.position_ned_m[:2], (-15.0, 10.0)) < 2.0
    world = World.of(shape_of(known) for known in load_mission(MISSION).known_obstacles)
    assert not world.is_way_free(places[0], places[-1], 0.0), "the straight way is not blocked: this tests nothing"
    assert min(world.signed_distance_m(place) for place in places) > BODY_AND_MARGIN_M
    assert len(texts) == 1
    assert "way home of" in texts[0]
    modes = read_recording(tmp_path / "run" / "e1.mcap").topic("/status").texts("flight_mode")
    assert "RETURN_TO_LAUNCH" not in modes


def test_a_pilot_who_takes_over_on_the_way_home_has_the_vehicle(tmp_path: Path) -> None:
    taken_s: list[float] = []

    def take(fleet: VirtualFleet) -> None:
        one = fleet.vehicles["e1"]
        if not taken_s and one.loop.guidance is Guidance.WAY:
            one.station.core.pilot_takes(Mode.POSCTL)
            taken_s.append(fleet.clock.now_s())
        elif taken_s and fleet.clock.now_s() > taken_s[0] + 3.0:
            fleet.stop()

    one = fly_virtual(MISSION, SIM, tmp_path, seed=1, watch=take).vehicles["e1"]
    assert one.station.core.piloted
    assert one.loop.phase == "released"
    assert one.autopilot.sent[-1][0] < taken_s[0] + 1.2  # a heartbeat tells of it within a second
    assert [what for t_s, what in one.autopilot.commanded if t_s > taken_s[0]] == []


def test_where_everything_is_blocked_it_lands_where_it_is_and_is_under_the_guards_until_it_knows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    thought_s: list[float] = []
    for name in ("plan", "is_return_free"):
        thinks = getattr(WayHome, name)
        noting = lambda self, *given, thinks=thinks: (thought_s.append(self.ways._clock.now_s()), thinks(self, *given))[1]  # noqa: E731
        monkeypatch.setattr(WayHome, name, noting)
    closed = tmp_path / "closed.toml"
    closed.write_text(MISSION.read_text().replace("width_m = 26.0", "width_m = 49.0").replace("limit_s = 17.0", "limit_s = 5.0"))
    fleet, places, texts = flown(closed, tmp_path / "run")
    one = fleet.vehicles["e1"]
    assert not one.station.core.armed
    assert texts[-1] == "landing instead"
    planned_s, judged_s = thought_s
    assert sum(planned_s < sent[0] < judged_s for sent in one.autopilot.sent) > 2, "the control loop waited for the planning"
    assert math.dist(one.position_ned_m[:2], places[0][:2]) < 3.0


def test_the_autopilots_return_through_a_known_obstacle_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "mission.toml"
    path.write_text(MISSION.read_text().replace('way_home = "planned"', ""))
    with pytest.raises(InputError, match=r"known_obstacles\[0\] reaches up without end.*set way_home = \"planned\""):
        load_mission(path)


@pytest.mark.parametrize(
    ("good", "bad", "sentence"),
    [
        ('shape = "box"', 'shape = "cone"', r"known_obstacles\[0\]\.shape = 'cone': must be one of 'cylinder', 'box', 'sphere'"),
        ('shape = "box"', "", r"known_obstacles\[0\]\.shape: missing; this field is required"),
        ("radius_m = 3.0", "radius_m = 3.0\nzzz = 1.0", r"zzz = 1.0: unknown field; known here: bottom_m, east_m, north_m"),
        ("radius_m = 3.0", "radius_m = -3.0", r"known_obstacles\[1\]\.radius_m = -3.0: must be greater than 0"),
    ],
)
def test_a_bad_known_obstacle_is_named_as_the_file_names_it(tmp_path: Path, good: str, bad: str, sentence: str) -> None:
    path = tmp_path / "mission.toml"
    path.write_text(MISSION.read_text().replace(good, bad))
    with pytest.raises(InputError, match=sentence):
        load_mission(path)

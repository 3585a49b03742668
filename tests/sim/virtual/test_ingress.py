"""Ingress by a planned way, flown by the whole application on the virtual clock; the evader is played."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from flightapp.config.mission import load_mission
from flightapp.core.errors import InputError
from flightapp.fleet.messages.command import Command
from flightapp.recording.reader import Recording, read_recording
from flightapp.runtime import ingress, way_follower
from flightapp.runtime.outcome import Outcome
from flightapp.runtime.way_planner import shape_of
from flightapp.sim.fault_script import Fault
from flightapp.sim.virtual.fleet import VirtualFleet, VirtualVehicle
from flightapp.sim.virtual.mission import fly_virtual
from flightapp.space.world import World
from tests.sim.virtual.played import Played

ROOT = Path(__file__).parents[3]
SIM = ROOT / "profiles/sim.toml"
MISSION = Path(__file__).with_name("past_a_block.toml")
STATION = (10.0, 0.0)
BODY_AND_MARGIN_M = 0.8
FAR = (24.0, 0.0, -4.0)


class Flight:
    """One flight of the pursuer; `during` is called at every step, and may stop it."""

    def __init__(self, during: Callable[[Flight], None]) -> None:
        self._during = during
        self.evader = Played("e1", "evader", 7)
        self.phases: list[str] = []
        self.places: dict[str, list[np.ndarray]] = {}
        self.ingress_s = math.nan
        self.is_aborted = False

    def fly(self, mission: Path, run: Path) -> Flight:
        self.run = run
        fly_virtual(mission, SIM, run, seed=1, watch=self._watch, flown=["p1"], time_limit_s=150.0)
        return self

    @property
    def one(self) -> VirtualVehicle:
        return self.fleet.vehicles["p1"]

    @property
    def recording(self) -> Recording:
        return read_recording(self.run / "p1.mcap")

    def texts(self, name: str) -> list[str]:
        events = self.recording.topic("/event")
        return [text for one, text in zip(events.texts("name"), events.texts("text"), strict=True) if one == name]

    def command(self, action: str) -> None:
        self.fleet.network.command(self.fleet.mission.fleet, "p1", Command(action, f"{action}-1", self.now_s, "Ann"))

    def _watch(self, fleet: VirtualFleet) -> None:
        self.fleet, self.now_s = fleet, fleet.clock.now_s()
        phase = self.one.loop.phase
        if phase == "ingress" and "ingress" not in self.phases:
            self.ingress_s = self.now_s
        if phase not in self.phases:
            self.phases.append(phase)
        self.places.setdefault(phase, []).append(self.one.position_ned_m)
        self.evader.play(fleet, FAR)
        self._during(self)


def test_it_flies_past_the_block_to_its_station_is_held_on_the_way_and_pursues_from_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(way_follower, "STALLED_S", 1.0)
    told: list[tuple[str, float]] = []
    held: list[np.ndarray] = []

    def during(flight: Flight) -> None:
        since_s = flight.now_s - flight.ingress_s
        for action, at_s in (("hold", 3.0), ("resume", 6.0)):  # longer than it waits without progress
            if since_s > at_s and action not in [one for one, _ in told]:
                flight.command(action)
                told.append((action, since_s))
        if 5.0 < since_s < 6.0:
            held.append(flight.one.position_ned_m)
        if flight.phases[-1] == "pursue":
            flight.fleet.stop()

    flight = Flight(during).fly(MISSION, tmp_path)
    assert flight.phases[-2:] == ["ingress", "pursue"]
    assert math.dist(held[0], held[-1]) < 0.3
    assert abs(held[0][0]) < 20.0
    places = flight.places["ingress"]
    assert math.dist(places[-1][:2], STATION) < 1.5
    world = World.of(shape_of(known) for known in load_mission(MISSION).known_obstacles)
    assert not world.is_way_free(places[0], places[-1], 0.0), "the straight way is not blocked: this tests nothing"
    assert min(world.signed_distance_m(place) for place in places) > BODY_AND_MARGIN_M
    (way,) = flight.recording.topic("/way").messages
    assert way["purpose"] == "ingress"
    assert math.dist(way["places_ned_m"][-1][:2], STATION) < 0.1


def test_an_abort_on_the_way_lands_it_there(tmp_path: Path) -> None:
    def during(flight: Flight) -> None:
        if flight.now_s - flight.ingress_s > 3.0 and flight.phases[-1] == "ingress" and not flight.is_aborted:
            flight.is_aborted = True
            flight.command("abort")
        if flight.one.station.core.mode.name == "LAND":
            flight.fleet.stop()

    flight = Flight(during).fly(MISSION, tmp_path)
    assert flight.phases[-2:] == ["ingress", "land"]
    assert math.dist(flight.places["land"][-1][:2], STATION) > 5.0


def test_without_an_own_position_it_stops_and_lands(tmp_path: Path) -> None:
    lost_s: list[float] = []

    def during(flight: Flight) -> None:
        if flight.now_s - flight.ingress_s > 4.0 and not lost_s:
            lost_s.append(flight.now_s)
            flight.one.faults.add(Fault.model_validate({"target": "telemetry", "verb": "off", "at_s": 0.0, "duration_s": 20.0}))
        if flight.one.station.core.mode.name == "LAND":
            flight.fleet.stop()

    flight = Flight(during).fly(MISSION, tmp_path)
    assert flight.phases[-2:] == ["ingress", "land"]
    assert 2.0 < flight.now_s - lost_s[0] < 6.0
    assert float(np.linalg.norm(flight.one.velocity_ned_m_s[:2])) < 0.6


SECOND = """
[[vehicles]]
name = "p2"
role = "pursuer"
system_id = 2
start = { north_m = -15.0, east_m = -8.0 }
station = { north_m = 10.0, east_m = -8.0 }
strategy = { name = "ac2f" }
camera = false

[[known_obstacles]]
"""


def test_where_one_begins_early_the_others_leave_their_ingress_and_join(tmp_path: Path) -> None:
    mission = tmp_path / "mission.toml"
    mission.write_text(MISSION.read_text().replace("\n[[known_obstacles]]\n", SECOND, 1))
    evader = Played("e1", "evader", 7)
    phases: dict[str, list[str]] = {"p1": [], "p2": []}
    begun_s: dict[str, float] = {}

    def watch(fleet: VirtualFleet) -> None:
        evader.play(fleet, (-6.0, 16.0, -4.0))
        for name, told in phases.items():
            phase = fleet.vehicles[name].loop.phase
            if phase not in told:
                told.append(phase)
                begun_s[name] = fleet.clock.now_s()
        if all(told[-1] == "pursue" for told in phases.values()):
            fleet.stop()

    (tmp_path / "run").mkdir()
    fleet = fly_virtual(mission, SIM, tmp_path / "run", seed=1, watch=watch, flown=["p1", "p2"], time_limit_s=60.0)
    assert all(told[-1] == "pursue" for told in phases.values())
    assert abs(begun_s["p1"] - begun_s["p2"]) < 1.5
    for name, told in (("p1", "the evader is"), ("p2", "p1 pursues already")):
        assert math.dist(fleet.vehicles[name].position_ned_m[:2], STATION) > 8.0
        events = read_recording(tmp_path / "run" / f"{name}.mcap").topic("/event").texts("text")
        assert any(text.startswith(f"ends on the way: {told}") for text in events)


def test_held_up_again_and_again_it_gives_up_and_returns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(way_follower, "STALLED_S", 0.5)
    monkeypatch.setattr(ingress, "WAYS_TRIED", 2)

    def during(flight: Flight) -> None:
        if flight.now_s - flight.ingress_s > 2.0 and flight.one.camera is not None:
            flight.one.camera.fault = "off"
        if flight.phases[-1] == "return":
            flight.fleet.stop()

    mission = tmp_path / "mission.toml"
    mission.write_text(MISSION.read_text().replace("camera = false", "camera = true", 1))
    flight = Flight(during).fly(mission, tmp_path)
    assert flight.phases[-2:] == ["ingress", "return"]
    assert sum("held up on the ingress: no progress" in text for text in flight.texts("ingress")) == 2


def test_without_a_way_it_stays_on_the_ground(tmp_path: Path) -> None:
    mission = tmp_path / "mission.toml"
    mission.write_text(MISSION.read_text().replace("width_m = 26.0", "width_m = 49.0"))
    flight = Flight(lambda _: None).fly(mission, tmp_path)
    assert flight.one.outcome is Outcome.FAULT
    assert "takeoff" not in flight.phases
    assert any("no ingress around what is known: no way from start to goal" in text for text in flight.texts("fault"))


@pytest.mark.parametrize(
    ("good", "bad", "sentence"),
    [
        ('ingress = "planned"\n', "", r'vehicles\[0\]\.station: it is flown to only with ingress = "planned"'),
        ("station = { north_m = 10.0, east_m = 0.0 }\n", "", r'ingress = "planned": no vehicle has a station'),
        ("station = { north_m = 10.0", "station = { north_m = 40.0", r"vehicles\[0\]\.station = \(40.0, 0.0\): lies outside"),
        ("station = { north_m = 10.0", "station = { north_m = 3.3", r"'p1' would fly 4 to 4 m above it, inside or closer than"),
        (
            "start = { north_m = -15.0",
            "start = { north_m = -2.0",
            r"start = \(-2.0, 0.0\): 'p1' would fly 0 to 5 m above",
        ),
    ],
)
def test_a_station_or_a_start_that_cannot_be_is_refused(tmp_path: Path, good: str, bad: str, sentence: str) -> None:
    path = tmp_path / "mission.toml"
    path.write_text(MISSION.read_text().replace(good, bad, 1))
    with pytest.raises(InputError, match=sentence):
        load_mission(path)

"""A strategy that traps itself between rows of towers, and the planned way out; the evader is played."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np

from flightapp.config.mission import load_mission
from flightapp.fleet.messages.command import Command
from flightapp.recording.reader import read_recording
from flightapp.replay.replay import Wanted, replay
from flightapp.runtime.way_planner import shape_of
from flightapp.sim.autopilot_modes import Mode
from flightapp.sim.virtual.fleet import VirtualFleet, VirtualVehicle
from flightapp.sim.virtual.mission import fly_virtual
from flightapp.space.world import World
from tests.sim.virtual.played import Played

ROOT = Path(__file__).parents[3]
SIM = ROOT / "profiles/sim.toml"
MISSION = Path(__file__).with_name("in_a_trap.toml")
EVADER = (20.0, 0.0, -4.0)
BODY_M = 0.35
TRAPPED_M = 3.4
"""Farther north than this is not inside."""


class Flight:
    """One flight of the pursuer until its pursuit is over, or until `during` stops it."""

    def __init__(self, mission: Path, run: Path, during: Callable[[Flight, VirtualVehicle], None] = lambda *_: None) -> None:
        self._during = during
        self._evader = Played("e1", "evader", 7)
        self.places: list[np.ndarray] = []
        self.detours: list[bool] = []
        self.now_s = 0.0
        self.run = run
        fly_virtual(mission, SIM, run, seed=1, watch=self._watch, flown=["p1"], time_limit_s=120.0)

    def _watch(self, fleet: VirtualFleet) -> None:
        self.fleet, self.now_s = fleet, fleet.clock.now_s()
        self._evader.play(fleet, EVADER)
        one = fleet.vehicles["p1"]
        self.places.append(one.position_ned_m)
        self.detours.append(one.loop.is_detoured)
        self._during(self, one)
        if one.loop.outcome is not None and one.loop.phase == "return":
            fleet.stop()

    @property
    def outcome(self) -> str | None:
        return self.fleet.vehicles["p1"].loop.outcome

    def command(self, action: str) -> None:
        self.fleet.network.command(self.fleet.mission.fleet, "p1", Command(action, f"{action}-1", self.now_s, "Ann"))


def test_trapped_between_towers_it_is_led_out_and_captures(tmp_path: Path) -> None:
    flight = Flight(MISSION, tmp_path)
    assert flight.outcome == "captured"
    world = World.of(shape_of(known) for known in load_mission(MISSION).known_obstacles)
    assert min(world.signed_distance_m(place) for place in flight.places if place[2] < -2.0) > BODY_M
    recording = read_recording(tmp_path / "p1.mcap")
    events = recording.topic("/event")
    told = [text for name, text in zip(events.texts("name"), events.texts("text"), strict=True) if name == "way_out"]
    assert told[0].startswith("trapped: ")
    assert told[1].startswith("way out of ")
    assert told[2] == "the strategy flies on: the way to the evader is free"
    assert [way["purpose"] for way in recording.topic("/way").messages] == ["way out"]
    assert replay(Wanted(tmp_path)).identical


def test_without_a_way_out_it_stays_where_it_is(tmp_path: Path) -> None:
    alone = tmp_path / "alone.toml"
    alone.write_text(MISSION.read_text().replace('way_out = "planned"', "").replace("limit_s = 60.0", "limit_s = 22.0"))
    (tmp_path / "run").mkdir()
    flight = Flight(alone, tmp_path / "run")
    assert flight.outcome == "timeout"
    assert max(place[0] for place in flight.places) < TRAPPED_M


def test_a_person_stops_it_on_the_way_out_and_lets_it_go_on_and_a_pilot_takes_it(tmp_path: Path) -> None:
    begun_s = [math.inf]
    held: list[float] = []
    at: dict[str, np.ndarray] = {}

    def during(flight: Flight, one: VirtualVehicle) -> None:
        if begun_s[0] == math.inf and one.loop.is_detoured and not one.loop.is_standing:
            begun_s[0] = flight.now_s
        for action, at_s in (("hold", 3.0), ("resume", 6.5), ("pilot", 10.0)):
            if flight.now_s > begun_s[0] + at_s and action not in at:
                at[action] = one.position_ned_m
                if action == "pilot":
                    one.station.core.pilot_takes(Mode.POSCTL)
                else:
                    flight.command(action)
        if 5.8 < flight.now_s - begun_s[0] < 6.5:
            held.append(float(np.linalg.norm(one.velocity_ned_m_s)))
        if flight.now_s > begun_s[0] + 13.0:
            flight.fleet.stop()

    flight = Flight(MISSION, tmp_path, during)
    one = flight.fleet.vehicles["p1"]
    assert max(held) < 0.3
    assert math.dist(at["resume"], at["pilot"]) > 1.5, "it did not go on after the hold"
    assert one.loop.phase == "released"
    assert one.autopilot.sent[-1][0] < begun_s[0] + 11.3

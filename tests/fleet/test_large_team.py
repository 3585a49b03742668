"""Ten vehicles on a lossy network whose distant mates are told every fourth state: nobody looks lost who is not."""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from flightapp.config.profile import load_profile
from flightapp.fleet.messages.intent import Intent
from flightapp.fleet.messages.state import State
from flightapp.fleet.team import Team
from flightapp.runtime.teamwork import Teamwork
from flightapp.sim.link_shaper import LinkQuality, LinkShaper
from flightapp.sim.virtual.network import VirtualNetwork

PROFILE = load_profile(Path(__file__).parents[2] / "profiles/sim.toml")
PERIOD_S = 0.05
LOSS = 0.05
INTENT = Intent("pursuer", "0123456789ab", 1, "coarse", None, None, None, None, None, ())
NAMES = tuple(f"p{number}" for number in range(10))


class Time:
    """Virtual time and what is to happen in it."""

    def __init__(self) -> None:
        self.now_s = 1000.0
        self._waiting: list[tuple[float, int, Callable[[], None]]] = []
        self._count = itertools.count()

    def call_later(self, delay_s: float, action: Callable[[], None]) -> None:
        heapq.heappush(self._waiting, (self.now_s + delay_s, next(self._count), action))

    def go_on(self, until_s: float) -> None:
        while self._waiting and self._waiting[0][0] <= until_s:
            self.now_s, _, action = heapq.heappop(self._waiting)
            action()
        self.now_s = until_s


class Vehicle:
    """Flies north, `number` times 15 m beside p0."""

    def __init__(self, number: int, network: VirtualNetwork) -> None:
        self.name, self._number = NAMES[number], number
        self.events: list[tuple[str, str]] = []
        others = [name for name in NAMES if name != self.name]
        self.team = Team(network.session(self.name), "f", self.name, others, lambda *_: None)
        rooms: Any = SimpleNamespace(
            team=self.team,
            journal=SimpleNamespace(event=self._note),
            profile=PROFILE,
            mission=SimpleNamespace(vehicles=[SimpleNamespace(name=name, role="pursuer") for name in NAMES]),
            limits=PROFILE.limits,
        )
        self.teamwork = Teamwork(rooms)

    def tick(self, now_s: float) -> None:
        self.team.poll(now_s)
        self.teamwork.note_silence(now_s)
        place = (3.0 * now_s, 15.0 * self._number, -5.0)
        self.teamwork.tell(State(now_s, place, (3.0, 0.0, 0.0), 0.0, airborne=True, phase="pursue", outcome=None), INTENT, now_s)

    def _note(self, _level: str, kind: str, _text: str, **facts: str) -> None:
        self.events.append((kind, facts["peer"]))


def fly(vehicles: list[Vehicle], time: Time, seconds: float, until: Callable[[], bool] = lambda: False) -> float:
    began_s = time.now_s
    while time.now_s < began_s + seconds and not until():
        time.go_on(time.now_s + PERIOD_S)
        for vehicle in vehicles:
            vehicle.tick(time.now_s)
    return time.now_s - began_s


def team() -> tuple[list[Vehicle], Time, VirtualNetwork]:
    time = Time()
    network = VirtualNetwork(time.call_later, lambda: time.now_s)
    network.shaper = LinkShaper(LinkQuality(0.03, 0.02, LOSS), 1)
    return [Vehicle(number, network) for number in range(len(NAMES))], time, network


def test_mates_on_the_slow_rate_are_heard_at_it_believed_and_never_lost() -> None:
    vehicles, time, _ = team()
    fly(vehicles, time, 4.0)
    before = {name: peer.taken for name, peer in vehicles[0].team.peers.items()}
    fly(vehicles, time, 12.0)
    rates_hz = {name: (peer.taken - before[name]) / 12.0 for name, peer in vehicles[0].team.peers.items()}
    assert 15.0 < rates_hz["p1"] < 20.5, "the nearest"
    assert all(4.0 < rates_hz[name] < 5.5 for name in NAMES[4:])
    for vehicle in vehicles:
        assert vehicle.events == []
        assert len(vehicle.teamwork.members(time.now_s, active_only=True)) == 9
        assert max(member.age_s for member in vehicle.teamwork.members(time.now_s, active_only=True)) < 0.7
    far = vehicles[0].team.peers["p9"]
    assert 0 < far.lost < 0.15 * far.taken, "what was not meant for it does not count as lost"


def test_a_mate_on_the_slow_rate_that_dies_is_noticed_within_a_second() -> None:
    vehicles, time, network = team()
    fly(vehicles, time, 4.0)
    network.cut_off.add("p9")
    took_s = fly(vehicles[:9], time, 5.0, lambda: ("teammate_lost", "p9") in vehicles[0].events)
    assert 0.5 < took_s <= 1.0
    assert math.isclose(vehicles[0].team.peers["p9"].state.due_s, 0.2)  # type: ignore[union-attr]

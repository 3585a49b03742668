"""A fleet with certificates on loopback, and the sessions of its members and of those who are none."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import zenoh

from flightapp.fleet.messages.intent import Intent
from flightapp.fleet.messages.state import State
from flightapp.fleet.security.access import Membership
from flightapp.fleet.security.credentials import load_credentials
from flightapp.fleet.security.keys import KeyWish, make_keys
from flightapp.fleet.session import zenoh_config
from flightapp.fleet.team import Team
from flightapp.sim.fleet_files import ReservedPorts

FLEET = "f"
VEHICLES = ("p1", "p2", "e1")


def make_fleet_keys(folder: Path, now_s: float | None = None, days: float = 1.0) -> Path:
    hosts = dict.fromkeys(VEHICLES, ("127.0.0.1",))
    make_keys(KeyWish(folder, FLEET, VEHICLES, hosts, days), time.time() if now_s is None else now_s)
    return folder


def until(condition: Callable[[], bool], timeout_s: float = 10.0) -> None:
    deadline = time.monotonic() + timeout_s
    while not condition():
        assert time.monotonic() < deadline, "condition not met in time"
        time.sleep(0.005)


@dataclass
class Loopback:
    """Sessions on ports of their own, closed together."""

    keys: Path
    ports: ReservedPorts = field(default_factory=lambda: ReservedPorts(8))
    opened: list[zenoh.Session] = field(default_factory=list)

    def endpoint(self, index: int, protocol: str = "quic") -> str:
        return f"{protocol}/127.0.0.1:{self.ports.numbers[index]}"

    def member(self, name: str, listen: list[str], connect: list[str], *, obeys_rules: bool = True) -> zenoh.Session:
        """Somebody with the certificate of `name`; one who does not obey the rules filters nothing, neither in nor out."""
        membership = Membership(FLEET, VEHICLES, load_credentials(self.keys / name), access_control=obeys_rules)
        return self._open(zenoh_config(listen, connect, wait_for_peers=False, membership=membership))

    def with_certificates_of(self, keys: Path, name: str, connect: list[str]) -> zenoh.Session:
        membership = Membership(FLEET, VEHICLES, load_credentials(keys / name), access_control=False)
        return self._open(zenoh_config([], connect, wait_for_peers=False, membership=membership))

    def plain(self, connect: list[str]) -> zenoh.Session:
        return self._open(zenoh_config([], connect, wait_for_peers=False))

    def close(self) -> None:
        for session in self.opened:
            session.close()
        self.ports.release()

    def _open(self, config: zenoh.Config) -> zenoh.Session:
        self.opened.append(zenoh.open(config))
        return self.opened[-1]


def own_state(t_s: float) -> State:
    return State(t_s, (1.0, 2.0, -5.0), (0.0, 0.0, 0.0), 0.0, airborne=True, phase="pursue", outcome=None)


def own_intent(mode: str = "coarse") -> Intent:
    return Intent("pursuer", "0123456789ab", 1, mode, None, None, None, None, None, ())


@dataclass
class Vehicle:
    """The part of a vehicle that talks: publishes, polls and obeys, a tick a call."""

    name: str
    session: zenoh.Session
    complaints: list[str] = field(default_factory=list)
    obeyed: list[str] = field(default_factory=list)
    clock_ahead_s: float = 0.0

    def __post_init__(self) -> None:
        others = [other for other in VEHICLES if other != self.name]
        self.team = Team(self.session, FLEET, self.name, others, lambda peer, text: self.complaints.append(f"{peer}: {text}"))

    def tick(self) -> None:
        now_s = time.time() + self.clock_ahead_s
        self.team.publish(own_state(now_s), own_intent(), now_s)
        self.team.poll(now_s)
        for command, answer in self.team.take_commands(now_s, lambda command: (True, f"obeys {command.action}")):
            if answer.accepted:
                self.obeyed.append(command.action)

    def hears(self, other: str, since_s: float) -> bool:
        self.tick()
        state = self.team.peers[other].state
        return state is not None and state.t_s >= since_s

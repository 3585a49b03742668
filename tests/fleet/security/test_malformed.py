"""Noise and spoilt messages of every kind, over real Zenoh: refused with a sentence, and the next good one is taken."""

from __future__ import annotations

import time
from pathlib import Path
from random import Random
from typing import Any

import zenoh

from flightapp.fleet.coordination.agreement import Verdict
from flightapp.fleet.coordination.plan import Plan, Seat
from flightapp.fleet.election.beacon import Beacon, Role
from flightapp.fleet.messages.codec import Header, Kind, encode
from flightapp.fleet.messages.discs import DISCS, Disc, Discs
from flightapp.fleet.messages.election import ELECTION
from flightapp.fleet.messages.intent import INTENT
from flightapp.fleet.messages.keys import key
from flightapp.fleet.messages.plan import PLAN
from flightapp.fleet.messages.sighting import SIGHTING, Sighting
from flightapp.fleet.messages.state import STATE
from flightapp.fleet.messages.verdict import VERDICT
from flightapp.fleet.post import Post
from tests.fleet.security.members import FLEET, Loopback, make_fleet_keys, own_intent, own_state, until

ROUNDS = 30
DEPTH = 4


def good_messages(now_s: float) -> dict[Kind[Any, Any], object]:
    return {
        STATE: own_state(now_s),
        INTENT: own_intent(),
        ELECTION: Beacon(now_s, 3, Role.LEADER, (("p1", now_s),)),
        PLAN: Plan(3, 1, (Seat("p1", 0.0, 1.0, 2.0, now_s + 5.0), Seat("p2", 3.0, 1.0, 2.0, now_s + 6.0))),
        VERDICT: Verdict(frozenset(("p1", "p2"))),
        SIGHTING: Sighting(now_s, 1.0, 2.0, 0.5, 0.2, 0.1),
        DISCS: Discs(now_s, (Disc(1.0, 2.0, 0.5, 0.0, 0.0),)),
    }


def spoilt(payload: bytes, random: Random) -> bytes:
    """Noise, or `payload` cut and with some bytes changed."""
    if random.random() < 0.4:
        return random.randbytes(random.randrange(0, 1200))
    changed = bytearray(payload[: len(payload) - random.randrange(0, 6)])
    for _ in range(random.randrange(1, 5)):
        changed[random.randrange(len(changed))] = random.randrange(256)
    return bytes(changed)


class Exchange:
    """p1, who takes messages of one kind, and the certified member p2, who sends them."""

    def __init__(self, victim: zenoh.Session, rogue: zenoh.Session, kind: Kind[Any, Any]) -> None:
        self.kind, self.random, self.sequence = kind, Random(6), 0
        self.complaints: list[str] = []
        self.inlet = Post(victim, FLEET, "p1", ["p2"], lambda _, text: self.complaints.append(text)).inlet(kind, DEPTH)
        self.publisher = rogue.declare_publisher(key(FLEET, "p2", kind.name))

    def spoilt_is_refused(self) -> bool:
        self.publisher.put(spoilt(self._good(), self.random))
        self.inlet.take(time.time())
        return bool(self.complaints)

    def good_is_taken(self) -> bool:
        self.publisher.put(self._good())
        return any(type(message) is type(good_messages(0.0)[self.kind]) for _, message in self.inlet.take(time.time()))

    def _good(self) -> bytes:
        self.sequence, now_s = self.sequence + 1, time.time()
        return encode(self.kind, good_messages(now_s)[self.kind], Header("p2", self.sequence, now_s))


def test_whatever_arrives_of_any_kind_is_refused_or_taken_and_never_stops_the_next_good_one(tmp_path: Path) -> None:
    loopback = Loopback(make_fleet_keys(tmp_path / "keys"))
    try:
        victim = loopback.member("p1", [loopback.endpoint(0)], [])
        rogue = loopback.member("p2", [], [loopback.endpoint(0)], obeys_rules=False)
        for kind in good_messages(0.0):
            exchange = Exchange(victim, rogue, kind)
            until(exchange.spoilt_is_refused)
            for _ in range(ROUNDS):
                exchange.spoilt_is_refused()
            until(exchange.good_is_taken)
            assert all(exchange.complaints), kind.name
    finally:
        loopback.close()

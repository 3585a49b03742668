"""Listens to a fleet and asks its machines for their time. Publishes nothing, answers nothing.

Ring channels keep the newest message of each vehicle for the next poll: a watcher that hangs holds up nobody, and publications
that its link cannot carry are dropped by their senders.
"""

from __future__ import annotations

import zenoh

from flightapp.core.clock import Clock
from flightapp.fleet.clock_watch import ClockWatch
from flightapp.fleet.election.beacon import Beacon
from flightapp.fleet.messages.election import ELECTION
from flightapp.fleet.messages.sighting import SIGHTING, Sighting
from flightapp.fleet.peers import Peers
from flightapp.fleet.post import Post
from flightapp.fleet.security.access import OPERATOR
from flightapp.watch.data_model_heard import Heard


class FleetListener:
    """`run` measures clocks until cancelled, `poll` takes what arrived."""

    def __init__(self, session: zenoh.Session, fleet: str, vehicles: tuple[str, ...], clock: Clock) -> None:
        self._clock = clock
        self._complaints: list[str] = []
        post = Post(session, fleet, OPERATOR, vehicles, lambda vehicle, text: self._complaints.append(f"{vehicle}: {text}"))
        self._clocks = ClockWatch(post, clock, answers=False)
        self._peers = Peers(post)
        self._elections, self._sightings = post.inlet(ELECTION), post.inlet(SIGHTING)
        self._beacons: dict[str, tuple[float, Beacon]] = {}
        self._seen: dict[str, Sighting] = {}

    async def run(self) -> None:
        await self._clocks.run()

    def poll(self) -> Heard:
        """All that is known now."""
        now_s = self._clock.now_s()
        self._clocks.poll(now_s)
        self._peers.poll(now_s)
        for vehicle, beacon in self._elections.take(now_s):
            header = self._elections.senders[vehicle].newest
            if header is not None:
                self._beacons[vehicle] = header.sent_s, beacon
        self._seen.update(self._sightings.take(now_s))
        states = {name: peer.state for name, peer in self._peers.by_name.items() if peer.state is not None}
        complaints, self._complaints = tuple(self._complaints), []
        return Heard(now_s, states, dict(self._clocks.offsets), dict(self._beacons), dict(self._seen), complaints)

"""Messages of the fleet as one machine sends and receives them: an outlet or an inlet for every kind.

Polled once a control period; nothing here blocks, queues or starts a thread. Zenoh's ring channels keep the newest messages of
each sender and forget the rest, so who floods loses only its own.

    post = Post(session, fleet, "p1", ["p2", "e1"], on_malformed)
    states_out, states_in = post.outlet(STATE), post.inlet(STATE)
    states_out.put(state, now_s)
    for vehicle, state in states_in.take(now_s): ...
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from typing import Any, Generic, TypeVar

import zenoh

from flightapp.fleet.admission import Admission, Verdict
from flightapp.fleet.messages.codec import Header, Kind, MalformedPayloadError, decode, encode
from flightapp.fleet.messages.keys import key

COMPLAINTS_REMEMBERED = 64
WAITING_MAX = 64
FUTURE_COMPLAINT_AT = 20
"""Messages: a second of states. It takes less to measure the clock of a machine that has just come."""

M = TypeVar("M")
Complain = Callable[[str, str], None]
"""Vehicle whose doing it is, and one sentence."""


class Outlet(Generic[M]):
    """Sends one kind under the own name."""

    def __init__(self, session: zenoh.Session, fleet: str, name: str, kind: Kind[M, Any], complain: Complain) -> None:
        self._kind, self._name, self._complain = kind, name, complain
        self._sequence = 0
        self._publisher = session.declare_publisher(
            key(fleet, name, kind.name),
            congestion_control=zenoh.CongestionControl.DROP,
            priority=kind.delivery.priority,
            express=kind.delivery.express,
            reliability=kind.delivery.reliability,
        )

    def put(self, message: M, now_s: float) -> None:
        """Send; what cannot be said, a position that is no number for one, is complained about and not sent."""
        self._sequence += 1
        try:
            payload = encode(self._kind, message, Header(self._name, self._sequence, now_s))
        except (ValueError, OverflowError) as error:
            self._complain(self._name, f"own {self._kind.name} cannot be sent: {error}")
            return
        self._publisher.put(payload)


class Inlet(Generic[M]):
    """Receives one kind from `others`; `senders` has what was taken, lost and refused of each."""

    def __init__(
        self,
        session: zenoh.Session,
        fleet: str,
        others: Iterable[str],
        kind: Kind[M, Any],
        depth: int,
        clock_ahead_s: dict[str, float],
        complain: Complain,
    ) -> None:
        self._kind, self._clock_ahead_s, self._complain = kind, clock_ahead_s, complain
        self._depth = depth
        self._subscribers = {
            other: session.declare_subscriber(key(fleet, other, kind.name), zenoh.handlers.RingChannel(depth)) for other in others
        }
        self.senders = {other: Admission(kind.age_max_s) for other in self._subscribers}

    def take(self, now_s: float) -> list[tuple[str, M]]:
        """(vehicle, message) since the last call, at most `depth` of each vehicle, oldest first; stamps are on the own clock."""
        taken = []
        for vehicle, subscriber in self._subscribers.items():
            for sample in self._newest(subscriber):
                message = self._read(vehicle, sample.payload.to_bytes(), now_s)
                if message is not None:
                    taken.append((vehicle, message))
        return taken

    def _newest(self, subscriber: Any) -> Iterable[Any]:
        """What waits in the ring; whatever comes in meanwhile, this ends."""
        newest: deque[Any] = deque(maxlen=self._depth)
        for _ in range(WAITING_MAX):
            sample = subscriber.handler.try_recv()
            if sample is None:
                break
            newest.append(sample)
        return newest

    def _read(self, vehicle: str, payload: bytes, now_s: float) -> M | None:
        clock_ahead_s = self._clock_ahead_s.get(vehicle, 0.0)
        try:
            message, header = decode(self._kind, payload, clock_ahead_s)
        except MalformedPayloadError as error:
            self._complain(vehicle, str(error))
            return None
        if header.sender != vehicle:
            self._complain(vehicle, f"{self._kind.name} on the key of '{vehicle}' claims to be from '{header.sender}'")
            return None
        sender = self.senders[vehicle]
        verdict = sender.judge(header, clock_ahead_s, now_s)
        if verdict is Verdict.FUTURE and sender.counts[verdict] == FUTURE_COMPLAINT_AT:
            self._complain(vehicle, f"messages of '{vehicle}' are stamped in the future; synchronise the clocks of the machines")
        return message if verdict is Verdict.TAKEN else None


class Post:
    """What one machine, `name`, exchanges with `others`. on_malformed(vehicle, sentence): once for each sentence."""

    def __init__(self, session: zenoh.Session, fleet: str, name: str, others: Iterable[str], on_malformed: Complain) -> None:
        self.session = session
        self.fleet = fleet
        self.name = name
        self.others = tuple(others)
        self.clock_ahead_s: dict[str, float] = {}
        """What each other machine's clock is ahead of the own, as far as it is known: all inlets correct stamps by it."""
        self._on_malformed = on_malformed
        self._complaints: set[tuple[str, str]] = set()

    def outlet(self, kind: Kind[M, Any]) -> Outlet[M]:
        return Outlet(self.session, self.fleet, self.name, kind, self.complain)

    def inlet(self, kind: Kind[M, Any], depth: int = 1) -> Inlet[M]:
        """depth: how many messages of each vehicle are kept between two polls."""
        return Inlet(self.session, self.fleet, self.others, kind, depth, self.clock_ahead_s, self.complain)

    def complain(self, vehicle: str, text: str) -> None:
        """Once for each vehicle and text: who floods must not flood the log as well."""
        if (vehicle, text) not in self._complaints and len(self._complaints) < COMPLAINTS_REMEMBERED:
            self._complaints.add((vehicle, text))
            self._on_malformed(vehicle, text)

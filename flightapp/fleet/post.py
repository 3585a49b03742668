"""Messages of the fleet as one machine sends and receives them: an outlet or an inlet for every kind.

Polled once a control period; nothing here blocks, queues or starts a thread. Zenoh's ring channels keep the newest messages of
each sender and forget the rest, so who floods loses only its own.

    post = Post(session, fleet, "p1", ["p2", "e1"], on_malformed)
    states_out, states_in = post.outlet(STATE), post.inlet(STATE)
    states_out.put(state, now_s)
    for vehicle, state in states_in.take(now_s): ...

A packet costs some 30 bytes beside what is in it, on every link. So what `rides` may wait for the next state that goes to
everybody, and then shares its packet: `holds` says whether it does.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import zenoh

from flightapp.fleet.admission import Admission, Verdict
from flightapp.fleet.messages.codec import Header, Kind, MalformedPayloadError, decode, encode
from flightapp.fleet.messages.keys import key, key_to

COMPLAINTS_REMEMBERED = 64
WAITING_MAX = 64
FUTURE_COMPLAINT_AT = 20
"""Messages: a second of states. It takes less to measure the clock of a machine that has just come."""

M = TypeVar("M")
HELD_MAX_S = 0.3
"""Longer than a slow state takes to come: who sends no states, because it does not know where it is, still sends all else."""
Complain = Callable[[str, str], None]
"""Vehicle whose doing it is, and one sentence."""


class Outlet(Generic[M]):
    """Sends one kind under the own name."""

    def __init__(self, post: Post, kind: Kind[M, Any], *, addressed: bool) -> None:
        self._post, self._kind = post, kind
        self._everybody = self._lane(key(post.fleet, post.name, kind.name))
        to = post.others if addressed else ()
        self._lanes = {other: self._lane(key_to(post.fleet, post.name, kind.name, other)) for other in to}

    def put(self, message: M, now_s: float) -> None:
        """Send to everybody, at once or, if the kind `rides`, with the next state.

        What cannot be said, a position that is no number for one, is complained about and not sent.
        """
        if self._kind.rides:
            self.ride(message, now_s)
        else:
            self._send(self._everybody, message, now_s)

    def put_to(self, receivers: Iterable[str], message: M, now_s: float) -> None:
        """Send to each of `receivers` that there is, at once. Only of an `addressed` outlet."""
        for receiver in receivers:
            lane = self._lanes.get(receiver)
            if lane is not None:
                self._send(lane, message, now_s)

    def ride(self, message: M, now_s: float) -> None:
        """Send to everybody in the packet of the next state, in place of what still waits there of this kind."""
        if self._post.holds:
            self._post.hold(self, message, now_s)
        else:
            self.send_held(message, now_s)

    def send_held(self, message: M, now_s: float) -> None:
        self._send(self._everybody, message, now_s)

    def _lane(self, lane_key: str) -> _Lane:
        delivery = self._kind.delivery
        publisher = self._post.session.declare_publisher(
            lane_key,
            congestion_control=zenoh.CongestionControl.DROP,
            priority=delivery.priority,
            express=delivery.express,
            reliability=delivery.reliability,
        )
        return _Lane(publisher)

    def _send(self, lane: _Lane, message: M, now_s: float) -> None:
        lane.sequence += 1
        try:
            payload = encode(self._kind, message, Header(self._post.name, lane.sequence, now_s))
        except (ValueError, OverflowError) as error:
            self._post.complain(self._post.name, f"own {self._kind.name} cannot be sent: {error}")
            return
        lane.publisher.put(payload)


@dataclass(slots=True)
class _Lane:
    """One key on which one kind is sent; its messages are numbered."""

    publisher: Any
    sequence: int = 0


class Inlet(Generic[M]):
    """Receives one kind from the others; `senders` has what was taken, lost and refused of each."""

    def __init__(self, post: Post, kind: Kind[M, Any], depth: int, *, addressed: bool) -> None:
        self._kind, self._clock_ahead_s, self._complain = kind, post.clock_ahead_s, post.complain
        self._depth = depth
        self._subscribers = {
            other: [(False, self._ring(post, key(post.fleet, other, kind.name)))]
            + [(True, self._ring(post, key_to(post.fleet, other, kind.name, post.name)))] * addressed
            for other in post.others
        }
        self.senders = {other: Admission(kind.age_max_s) for other in self._subscribers}

    def _ring(self, post: Post, lane_key: str) -> Any:
        return post.session.declare_subscriber(lane_key, zenoh.handlers.RingChannel(self._depth))

    def take(self, now_s: float) -> list[tuple[str, M]]:
        """(vehicle, message) since the last call, oldest first of each vehicle; stamps are on the own clock.

        At most `depth` of each vehicle, and as many that were for this machine alone.
        """
        taken = []
        for vehicle, lanes in self._subscribers.items():
            read = []
            for addressed, subscriber in lanes:
                for sample in self._newest(subscriber):
                    opened = self._open(vehicle, sample.payload.to_bytes())
                    if opened is not None:
                        read.append((*opened, addressed))
            read.sort(key=lambda one: one[1].sent_s)
            taken += [(vehicle, message) for message, header, addressed in read if self._admits(header, now_s, addressed)]
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

    def _open(self, vehicle: str, payload: bytes) -> tuple[M, Header] | None:
        try:
            message, header = decode(self._kind, payload, self._clock_ahead_s.get(vehicle, 0.0))
        except MalformedPayloadError as error:
            self._complain(vehicle, str(error))
            return None
        if header.sender != vehicle:
            self._complain(vehicle, f"{self._kind.name} on the key of '{vehicle}' claims to be from '{header.sender}'")
            return None
        return message, header

    def _admits(self, header: Header, now_s: float, addressed: bool) -> bool:
        vehicle = header.sender
        sender = self.senders[vehicle]
        verdict = sender.judge(header, self._clock_ahead_s.get(vehicle, 0.0), now_s, addressed=addressed)
        if verdict is Verdict.FUTURE and sender.counts[verdict] == FUTURE_COMPLAINT_AT:
            self._complain(vehicle, f"messages of '{vehicle}' are stamped in the future; synchronise the clocks of the machines")
        return verdict is Verdict.TAKEN


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
        self.holds = False
        """Whether what `rides` waits for the next state to everybody: worth it where that is rarer than what there is to say."""
        self._held: dict[Outlet[Any], tuple[Any, float]] = {}

    def outlet(self, kind: Kind[M, Any], *, addressed: bool = False) -> Outlet[M]:
        """addressed: some of it is for one of the others alone."""
        return Outlet(self, kind, addressed=addressed)

    def inlet(self, kind: Kind[M, Any], depth: int = 1, *, addressed: bool = False) -> Inlet[M]:
        """depth: how many messages of each vehicle are kept between two polls. addressed: also what is for this machine alone."""
        return Inlet(self, kind, depth, addressed=addressed)

    def hold(self, outlet: Outlet[M], message: M, now_s: float) -> None:
        """Keep `message` until `release`, the newest of an outlet only."""
        since_s = self._held[outlet][1] if outlet in self._held else now_s
        self._held[outlet] = message, since_s

    def release(self, now_s: float, held_min_s: float = 0.0) -> None:
        """Send what waits for at least `held_min_s`: right before a state to everybody, which takes it along."""
        for outlet, (message, since_s) in list(self._held.items()):
            if now_s - since_s >= held_min_s:
                del self._held[outlet]
                outlet.send_held(message, now_s)

    def complain(self, vehicle: str, text: str) -> None:
        """Once for each vehicle and text: who floods must not flood the log as well."""
        if (vehicle, text) not in self._complaints and len(self._complaints) < COMPLAINTS_REMEMBERED:
            self._complaints.add((vehicle, text))
            self._on_malformed(vehicle, text)

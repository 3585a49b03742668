"""A fleet network on the virtual clock, with the part of Zenoh's interface that `fleet.post` uses.

It carries bytes, not objects, so that everything is encoded and decoded as in flight. Latency is constant unless a `shaper` makes
the links worse; a vehicle can be cut off, and what it sent or should have received meanwhile is gone, as over UDP. An operator's
links are never shaped.

As Zenoh does: what is published at the same moment with the same priority shares a packet, and a packet that a later one of its
priority has overtaken is dropped.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, cast

import zenoh

from flightapp.fleet.messages.command import Acknowledgement, Command, decode_acknowledgement, encode_command
from flightapp.fleet.messages.keys import command_key
from flightapp.sim.link_shaper import LinkShaper

LEASE_S = 1.5
WAITING_MAX = 64
"""Messages that wait for one reader; a real ring's capacity cannot be read, inlets keep as many as they want."""


@dataclass(frozen=True, slots=True)
class _Payload:
    content: bytes

    def to_bytes(self) -> bytes:
        return self.content


@dataclass(frozen=True, slots=True)
class _Sample:
    payload: _Payload


@dataclass(slots=True)
class _Mailbox:
    """What a subscriber or a queryable polls."""

    waiting: deque[Any]

    def try_recv(self) -> Any:
        return self.waiting.popleft() if self.waiting else None


@dataclass(slots=True)
class _Endpoint:
    owner: str
    handler: _Mailbox


@dataclass(slots=True)
class _Query:
    """One operator command on its way to one vehicle."""

    payload: _Payload
    key_expr: str
    answers: list[bytes] = field(default_factory=list)

    def reply(self, _key: str, payload: bytes) -> None:
        self.answers.append(payload)

    def __enter__(self) -> _Query:
        return self

    def __exit__(self, *_: object) -> None:
        return None


@dataclass(frozen=True, slots=True)
class _Reply:
    ok: _Sample | None


@dataclass(slots=True)
class _Question:
    """One that is answered at once by a function, as on Zenoh's own threads."""

    key_expr: str
    reply_with: Callable[[bytes], None]
    payload: _Payload | None = None

    def reply(self, _key: str, payload: bytes) -> None:
        self.reply_with(payload)

    def __enter__(self) -> _Question:
        return self

    def __exit__(self, *_: object) -> None:
        return None


@dataclass(frozen=True, slots=True)
class _TokenNews:
    key_expr: str
    kind: zenoh.SampleKind


@dataclass(slots=True)
class _Lane:
    """Packets of one priority from one vehicle to another, numbered."""

    sender: str
    sent_s: float | None = None
    delay_s: float | None = None
    """Of the packet sent last; None: it is lost."""
    number: int = 0
    newest: int = 0
    """Of those that have arrived."""


class _Tokens:
    """The liveliness tokens as one vehicle sees them: those of vehicles that are cut off go after a lease."""

    def __init__(self, network: VirtualNetwork, owner: str) -> None:
        self._network, self._owner = network, owner
        self._seen: set[str] = set()

    @property
    def handler(self) -> _Tokens:
        return self

    def try_recv(self) -> _TokenNews | None:
        for key in sorted(self._network.tokens):
            reachable = self._network.is_reachable(self._owner, self._network.tokens[key])
            if reachable != (key in self._seen):
                self._seen ^= {key}
                return _TokenNews(key, zenoh.SampleKind.PUT if reachable else zenoh.SampleKind.DELETE)
        return None


class VirtualNetwork:
    """The ether. `call_later(delay_s, action)` and `time()` are the event loop's."""

    def __init__(
        self,
        call_later: Callable[[float, Callable[[], None]], object],
        time: Callable[[], float],
        latency_s: float = 0.005,
    ) -> None:
        self._call_later = call_later
        self._time = time
        self.tokens: dict[str, str] = {}
        """Liveliness tokens and who declared them."""
        self._answering: dict[str, tuple[str, Callable[[Any], None]]] = {}
        self._reached_s: dict[tuple[str, str], float] = {}
        self._latency_s = latency_s
        self._subscribers: dict[str, list[_Endpoint]] = {}
        self._queryables: dict[str, _Endpoint] = {}
        self._lanes: dict[tuple[str, str, str], _Lane] = {}
        self.cut_off: set[str] = set()
        """Vehicles that neither send nor receive."""
        self.shaper: LinkShaper | None = None
        """What the links between vehicles do to packets; None: a constant latency."""

    def session(self, owner: str) -> zenoh.Session:
        """What `owner` sees of the network."""
        return cast(zenoh.Session, _Session(self, owner))

    def command(self, fleet: str, vehicle: str, command: Command) -> Callable[[], list[Acknowledgement]]:
        """Send an operator's command; the returned function tells the answers that have come so far."""
        key = command_key(fleet, vehicle)
        query = _Query(_Payload(encode_command(command)), key)
        self.deliver(self._queryables.get(key), query, "")
        return lambda: [decode_acknowledgement(answer) for answer in query.answers]

    def publish(self, sender: str, key: str, content: bytes, priority: zenoh.Priority) -> None:
        for endpoint in self._subscribers.get(key, ()):
            self._pass(endpoint, _Sample(_Payload(content)), self._lane(sender, endpoint.owner, str(priority)))

    def subscribe(self, key: str, endpoint: _Endpoint) -> None:
        self._subscribers.setdefault(key, []).append(endpoint)

    def answer(self, key: str, endpoint: _Endpoint) -> None:
        self._queryables[key] = endpoint

    def answer_at_once(self, key: str, owner: str, answer: Callable[[Any], None]) -> None:
        self._answering[key] = owner, answer

    def ask(self, asker: str, key: str, take: Callable[[_Reply], None]) -> None:
        """Ask whoever answers at once on `key`; the way there and the way back take the latency each."""
        owner, answer = self._answering.get(key, ("", None))
        if answer is None or asker in self.cut_off:
            return

        def back(content: bytes) -> None:
            delay_s = self._delay_s(owner, asker)
            if delay_s is not None and not {asker, owner} & self.cut_off:
                self._call_later(delay_s, lambda: take(_Reply(_Sample(_Payload(content)))))

        def arrive() -> None:
            if owner not in self.cut_off:
                answer(_Question(key, back))

        delay_s = self._delay_s(asker, owner)
        if delay_s is not None:
            self._call_later(delay_s, arrive)

    def is_reachable(self, one: str, other: str) -> bool:
        """Whether `one` still holds `other` for connected: until a lease after it was last reached."""
        now_s, pair = self._time(), (one, other)
        split = self.shaper is not None and self.shaper.is_cut(one, other)
        if not split and not {one, other} & self.cut_off:
            self._reached_s[pair] = now_s
        return now_s - self._reached_s.get(pair, -LEASE_S) < LEASE_S

    def deliver(self, endpoint: _Endpoint | None, item: object, sender: str) -> None:
        if endpoint is None or sender in self.cut_off:
            return

        def arrive() -> None:
            if endpoint.owner not in self.cut_off:
                endpoint.handler.waiting.append(item)

        delay_s = self._delay_s(sender, endpoint.owner)
        if delay_s is not None:
            self._call_later(delay_s, arrive)

    def _lane(self, sender: str, receiver: str, priority: str) -> _Lane:
        return self._lanes.setdefault((sender, receiver, priority), _Lane(sender))

    def _pass(self, endpoint: _Endpoint, item: object, lane: _Lane) -> None:
        """In the packet of this moment."""
        now_s = self._time()
        if lane.sent_s != now_s:
            lane.sent_s, lane.number, lane.delay_s = now_s, lane.number + 1, self._delay_s(lane.sender, endpoint.owner)
        if lane.delay_s is None or lane.sender in self.cut_off:
            return
        number = lane.number

        def arrive() -> None:
            if number >= lane.newest and endpoint.owner not in self.cut_off:
                lane.newest = number
                endpoint.handler.waiting.append(item)

        self._call_later(lane.delay_s, arrive)

    def _delay_s(self, sender: str, receiver: str) -> float | None:
        """Of one packet; None: lost. An operator has no name here."""
        return self._latency_s if self.shaper is None or not sender else self.shaper.delay_s(sender, receiver)


class _Publisher:
    def __init__(self, network: VirtualNetwork, owner: str, key: str, priority: zenoh.Priority) -> None:
        self._network, self._owner, self._key, self._priority = network, owner, key, priority

    def put(self, content: bytes) -> None:
        self._network.publish(self._owner, self._key, content, self._priority)


class _Session:
    """As `zenoh.Session`, for one vehicle."""

    def __init__(self, network: VirtualNetwork, owner: str) -> None:
        self._network, self._owner = network, owner

    def declare_publisher(self, key: str, *, priority: zenoh.Priority, **_: object) -> _Publisher:
        return _Publisher(self._network, self._owner, key, priority)

    def declare_subscriber(self, key: str, _handler: object) -> _Endpoint:
        endpoint = _Endpoint(self._owner, _Mailbox(deque(maxlen=WAITING_MAX)))
        self._network.subscribe(key, endpoint)
        return endpoint

    def declare_queryable(self, key: str, handler: object) -> _Endpoint | None:
        if callable(handler):
            self._network.answer_at_once(key, self._owner, handler)
            return None
        endpoint = _Endpoint(self._owner, _Mailbox(deque(maxlen=16)))
        self._network.answer(key, endpoint)
        return endpoint

    def get(self, key: str, take: Callable[[_Reply], None], **_: object) -> None:
        self._network.ask(self._owner, key, take)

    def liveliness(self) -> _Liveliness:
        return _Liveliness(self._network, self._owner)


class _Liveliness:
    def __init__(self, network: VirtualNetwork, owner: str) -> None:
        self._network, self._owner = network, owner

    def declare_token(self, key: str) -> None:
        self._network.tokens[key] = self._owner

    def declare_subscriber(self, _key: str, _handler: object, **_: object) -> _Tokens:
        return _Tokens(self._network, self._owner)

"""A fleet network on the virtual clock, with the part of Zenoh's interface that `fleet.post` uses.

It carries bytes, not objects, so that everything is encoded and decoded as in flight. Latency is constant; a vehicle can be cut
off, and what it sent or should have received meanwhile is gone, as over UDP.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, cast

import zenoh

from flightapp.fleet.messages.command import Acknowledgement, Command, decode_acknowledgement, encode_command
from flightapp.fleet.messages.keys import command_key

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


class VirtualNetwork:
    """The ether. `call_later(delay_s, action)` is the event loop's."""

    def __init__(self, call_later: Callable[[float, Callable[[], None]], object], latency_s: float = 0.005) -> None:
        self._call_later = call_later
        self._latency_s = latency_s
        self._subscribers: dict[str, list[_Endpoint]] = {}
        self._queryables: dict[str, _Endpoint] = {}
        self.cut_off: set[str] = set()
        """Vehicles that neither send nor receive."""

    def session(self, owner: str) -> zenoh.Session:
        """What `owner` sees of the network."""
        return cast(zenoh.Session, _Session(self, owner))

    def command(self, fleet: str, vehicle: str, command: Command) -> Callable[[], list[Acknowledgement]]:
        """Send an operator's command; the returned function tells the answers that have come so far."""
        key = command_key(fleet, vehicle)
        query = _Query(_Payload(encode_command(command)), key)
        self.deliver(self._queryables.get(key), query, "")
        return lambda: [decode_acknowledgement(answer) for answer in query.answers]

    def publish(self, sender: str, key: str, content: bytes) -> None:
        for endpoint in self._subscribers.get(key, ()):
            self.deliver(endpoint, _Sample(_Payload(content)), sender)

    def subscribe(self, key: str, endpoint: _Endpoint) -> None:
        self._subscribers.setdefault(key, []).append(endpoint)

    def answer(self, key: str, endpoint: _Endpoint) -> None:
        self._queryables[key] = endpoint

    def deliver(self, endpoint: _Endpoint | None, item: object, sender: str) -> None:
        if endpoint is None or sender in self.cut_off:
            return

        def arrive() -> None:
            if endpoint.owner not in self.cut_off:
                endpoint.handler.waiting.append(item)

        self._call_later(self._latency_s, arrive)


class _Publisher:
    def __init__(self, network: VirtualNetwork, owner: str, key: str) -> None:
        self._network, self._owner, self._key = network, owner, key

    def put(self, content: bytes) -> None:
        self._network.publish(self._owner, self._key, content)


class _Session:
    """As `zenoh.Session`, for one vehicle."""

    def __init__(self, network: VirtualNetwork, owner: str) -> None:
        self._network, self._owner = network, owner

    def declare_publisher(self, key: str, **_: object) -> _Publisher:
        return _Publisher(self._network, self._owner, key)

    def declare_subscriber(self, key: str, _handler: object) -> _Endpoint:
        endpoint = _Endpoint(self._owner, _Mailbox(deque(maxlen=WAITING_MAX)))
        self._network.subscribe(key, endpoint)
        return endpoint

    def declare_queryable(self, key: str, _handler: object) -> _Endpoint:
        endpoint = _Endpoint(self._owner, _Mailbox(deque(maxlen=16)))
        self._network.answer(key, endpoint)
        return endpoint

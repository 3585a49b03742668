"""The operator's side: watch every vehicle, command all of them or one, collect the acknowledgements."""

from __future__ import annotations

import asyncio
import getpass
import uuid
from collections.abc import Iterable

import zenoh

from flightapp.core.clock import Clock
from flightapp.fleet.messages import (
    Acknowledgement,
    Command,
    MalformedPayloadError,
    SharedState,
    command_key,
    decode_acknowledgement,
    decode_state,
    encode_command,
    state_key,
)


class Operator:
    """Listens to the states of `vehicles` and sends commands."""

    def __init__(self, session: zenoh.Session, fleet: str, vehicles: Iterable[str], clock: Clock) -> None:
        self._session = session
        self._fleet = fleet
        self._clock = clock
        self._subscribers = {
            name: session.declare_subscriber(state_key(fleet, name), zenoh.handlers.RingChannel(1)) for name in vehicles
        }
        self.states: dict[str, SharedState] = {}

    def poll(self) -> None:
        """Take the newest state of each vehicle; malformed ones are ignored."""
        for name, subscriber in self._subscribers.items():
            sample = subscriber.handler.try_recv()
            if sample is None:
                continue
            try:
                self.states[name] = decode_state(sample.payload.to_bytes())
            except MalformedPayloadError:
                continue

    async def command(self, action: str, vehicle: str | None = None, timeout_s: float = 1.0) -> list[Acknowledgement]:
        """Send `action` to `vehicle` or, with None, to the whole fleet; the answers that came in time."""
        command = Command(action, uuid.uuid4().hex, self._clock.now_s(), _user())
        return await asyncio.to_thread(self._ask, command, vehicle or "*", timeout_s)

    def _ask(self, command: Command, vehicle: str, timeout_s: float) -> list[Acknowledgement]:
        answers = []
        replies = self._session.get(
            command_key(self._fleet, vehicle),
            payload=encode_command(command),
            target=zenoh.QueryTarget.ALL,
            consolidation=zenoh.ConsolidationMode.NONE,
            timeout=timeout_s,
        )
        for reply in replies:
            if reply.ok is None:
                continue
            try:
                answers.append(decode_acknowledgement(reply.ok.payload.to_bytes()))
            except MalformedPayloadError:
                continue
        return answers


def _user() -> str:
    """Name of the person at the keyboard; empty where the system has none."""
    try:
        return getpass.getuser()
    except (KeyError, OSError):
        return ""

"""The fleet as somebody sees it who only looks on: the newest state of each vehicle."""

from __future__ import annotations

from collections.abc import Iterable

import zenoh

from flightapp.fleet.messages import MalformedPayloadError, SharedState, decode_state, state_key


class FleetView:
    """Polled; the ring of each subscription keeps the newest state only."""

    def __init__(self, session: zenoh.Session, fleet: str, vehicles: Iterable[str]) -> None:
        self._subscribers = {
            name: session.declare_subscriber(state_key(fleet, name), zenoh.handlers.RingChannel(1)) for name in vehicles
        }
        self.states: dict[str, SharedState] = {}

    def poll(self) -> None:
        """Take what has arrived; what cannot be read is passed over."""
        for name, subscriber in self._subscribers.items():
            sample = subscriber.handler.try_recv()
            if sample is None:
                continue
            try:
                self.states[name] = decode_state(sample.payload.to_bytes())
            except MalformedPayloadError:
                continue

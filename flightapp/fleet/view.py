"""The fleet as somebody sees it who only looks on: the newest state of each vehicle."""

from __future__ import annotations

from collections.abc import Iterable

import zenoh

from flightapp.fleet.peers import Peers
from flightapp.fleet.post import Post
from flightapp.fleet.shared_state import SharedState

ONLOOKER = "onlooker"


class FleetView:
    """Polled; the ring of each subscription keeps the newest only. What cannot be read is passed over."""

    def __init__(self, session: zenoh.Session, fleet: str, vehicles: Iterable[str]) -> None:
        self._peers = Peers(Post(session, fleet, ONLOOKER, vehicles, lambda _vehicle, _text: None))

    @property
    def states(self) -> dict[str, SharedState]:
        """Of those that were heard."""
        return {name: peer.state for name, peer in self._peers.by_name.items() if peer.state is not None}

    def poll(self, now_s: float) -> None:
        """Take what has arrived."""
        self._peers.poll(now_s)

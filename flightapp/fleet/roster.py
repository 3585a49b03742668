"""Who is on the fleet's network, by Zenoh's liveliness tokens: they tell who is here, states tell who is well.

A token goes when its process ends (at once over TCP, TLS and QUIC) or when the link has been silent for a lease (1.5 s).
"""

from __future__ import annotations

import zenoh

from flightapp.fleet.messages import keys
from flightapp.fleet.post import WAITING_MAX, Post

LOST_AGE_S = 0.7
LOST_PERIODS = 4.5
"""Of the last state of a vehicle that counts as lost: 14 messages in a row at 20 Hz, 4 at 5 Hz."""


def lost_age_s(state_rate_hz: float) -> float:
    """Age of the last state from which on a vehicle that sends `state_rate_hz` counts as lost: for its mates and who looks on."""
    return max(LOST_AGE_S, LOST_PERIODS / state_rate_hz)


class Roster:
    """`here`: names with a token now; `post.others` are those that the mission assigns."""

    def __init__(self, post: Post) -> None:
        liveliness = post.session.liveliness()
        self._post = post
        self._own = liveliness.declare_token(keys.key(post.fleet, post.name, keys.ALIVE))
        self._tokens = liveliness.declare_subscriber(
            keys.key(post.fleet, "*", keys.ALIVE), zenoh.handlers.RingChannel(WAITING_MAX), history=True
        )
        self.here: set[str] = set()
        self.left: set[str] = set()
        """Whose token went, and has not come back."""

    def poll(self) -> list[str]:
        """Take the news; returned are the strangers among those who came: names that are not of the mission."""
        strangers = []
        for _ in range(WAITING_MAX):
            sample = self._tokens.handler.try_recv()
            if sample is None:
                break
            name = str(sample.key_expr).split("/")[-2]
            if name == self._post.name:
                continue
            if sample.kind == zenoh.SampleKind.DELETE:
                self.here.discard(name)
                self.left.add(name)
                continue
            if name not in self.here and name not in self._post.others:
                strangers.append(name)
            self.here.add(name)
            self.left.discard(name)
        return strangers

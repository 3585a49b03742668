"""Asks the other machines for their time over Zenoh and answers them; keeps `Post.clock_ahead_s` up to date.

Answers are given and taken on Zenoh's own threads, where no wait for the next control period blurs them; what was measured waits
in a bounded queue for `poll`.
"""

from __future__ import annotations

import asyncio
from collections import deque
from functools import partial

import zenoh

from flightapp.core.clock import Clock
from flightapp.fleet.clock_offset import ClockOffset, Offset, RoundTrip
from flightapp.fleet.messages import keys
from flightapp.fleet.messages.clock import CLOCK, Now
from flightapp.fleet.messages.codec import Header, MalformedPayloadError, decode, encode
from flightapp.fleet.post import Post

QUICK_PERIOD_S = 0.1
"""Between questions to everybody while little is known of the clocks."""
QUICK_ROUNDS = 10
PERIOD_S = 1.0
PERIOD_PER_MACHINE_S = 0.5
"""In a large fleet each machine is asked less often: crystals drift apart by 0.1 ms a second at most."""
ANSWER_TIMEOUT_S = 0.5
WAITING_MAX = 256


class ClockWatch:
    """`run` asks, `poll` takes the answers; `offsets` has what is known of each other machine."""

    def __init__(self, post: Post, clock: Clock, *, answers: bool = True) -> None:
        """answers: False for who only looks on, and is asked by nobody."""
        self._post, self._clock = post, clock
        self._clocks = {other: ClockOffset() for other in post.others}
        self._waiting: deque[tuple[str, float, float, bytes]] = deque(maxlen=WAITING_MAX)
        if answers:
            self._queryable = post.session.declare_queryable(keys.key(post.fleet, post.name, keys.CLOCK), self._answer)
        self.offsets: dict[str, Offset] = {}

    async def run(self) -> None:
        """Ask until cancelled. A question costs the calling thread a fraction of a millisecond and waits for nothing."""
        rounds, period_s = 0, max(PERIOD_S, PERIOD_PER_MACHINE_S * len(self._post.others))
        while True:
            for other in self._post.others:
                self._ask(other)
                await asyncio.sleep(0)
            rounds += 1
            await asyncio.sleep(period_s if rounds >= QUICK_ROUNDS and self.offsets else QUICK_PERIOD_S)

    def poll(self, now_s: float) -> None:
        """Take the answers that came since the last poll."""
        while self._waiting:
            other, asked_s, answered_s, payload = self._waiting.popleft()
            try:
                _, header = decode(CLOCK, payload)
            except MalformedPayloadError as error:
                self._post.complain(other, str(error))
                continue
            if header.sender == other:
                self._clocks[other].note(RoundTrip(asked_s, header.sent_s, answered_s))
        for other, clock in self._clocks.items():
            offset = clock.offset(now_s)
            if offset is not None:
                self.offsets[other] = offset
                self._post.clock_ahead_s[other] = offset.ahead_s

    def _ask(self, other: str) -> None:
        asked_s = self._clock.now_s()
        key = keys.key(self._post.fleet, other, keys.CLOCK)
        self._post.session.get(key, partial(self._note, other, asked_s), timeout=ANSWER_TIMEOUT_S)

    def _note(self, other: str, asked_s: float, reply: zenoh.Reply) -> None:
        if reply.ok is not None:
            self._waiting.append((other, asked_s, self._clock.now_s(), reply.ok.payload.to_bytes()))

    def _answer(self, query: zenoh.Query) -> None:
        with query:
            query.reply(query.key_expr, encode(CLOCK, Now(), Header(self._post.name, 0, self._clock.now_s())))

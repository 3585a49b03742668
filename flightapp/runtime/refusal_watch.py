"""Records what a fleet with certificates refuses: who knocked and who overstepped, as events of the flight."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress

from flightapp.fleet.security.refusals import ZenohLog, connected_names, refusals
from flightapp.runtime.rooms import Rooms

PERIOD_S = 0.5
SENTENCES_MAX = 64
"""Who invents keys must not flood the recording."""


class RefusalReport:
    """Tells a sentence when it is new and whenever its count has grown tenfold."""

    def __init__(self, tell: Callable[[str], None]) -> None:
        self._tell = tell
        self._counts: Counter[str] = Counter()
        self._told: dict[str, int] = {}

    def add(self, found: Counter[str]) -> None:
        for sentence, count in found.items():
            if sentence not in self._told and len(self._told) >= SENTENCES_MAX:
                continue
            self._counts[sentence] += count
            if self._counts[sentence] >= 10 * self._told.get(sentence, 0):
                self._told[sentence] = self._counts[sentence]
                self._tell(f"refused: {sentence} ({self._counts[sentence]} times so far)")


@asynccontextmanager
async def watching_refusals(rooms: Rooms) -> AsyncIterator[None]:
    """Events while the context lasts; nothing in an open fleet. Standard output of the process is Zenoh's from now on."""
    if rooms.profile.network.certificates is None:
        yield
        return
    log, session = ZenohLog(), rooms.team.post.session
    report = RefusalReport(lambda sentence: rooms.journal.event("warning", "network", sentence))

    async def watch() -> None:
        while True:
            await asyncio.sleep(PERIOD_S)
            report.add(refusals(log.take(), connected_names(session)))

    task = asyncio.create_task(watch(), name="refusals")
    try:
        yield
    finally:
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task
        report.add(refusals(log.take(), connected_names(session)))

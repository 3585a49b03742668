"""Records what a fleet with certificates refuses: who knocked and who overstepped, as events of the flight."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress

from flightapp.fleet.security.refusals import RefusalReport, ZenohLog, connected_names, refusals
from flightapp.runtime.rooms import Rooms

PERIOD_S = 0.5


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

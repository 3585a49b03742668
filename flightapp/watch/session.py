"""One `flightapp watch` from its options to its end."""

from __future__ import annotations

import asyncio
import hashlib
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

from flightapp.config.mission import Mission, load_mission
from flightapp.config.profile import load_profile
from flightapp.core.clock import SystemClock
from flightapp.fleet.command import check_connect_option
from flightapp.fleet.security.access import Membership, membership_of
from flightapp.fleet.session import open_session
from flightapp.watch.backend_commands import Commander
from flightapp.watch.backend_fleet import FleetListener
from flightapp.watch.data_model_fleet import FleetModel, Overview
from flightapp.watch.data_model_rows import Link
from flightapp.watch.data_model_thresholds import Thresholds, thresholds_of
from flightapp.watch.frontend_app import Source, WatchApp

LINE_PERIOD_S = 1.0
POLL_PERIOD_S = 0.1
ONCE_TIMEOUT_S = 3.0
DIGEST_LENGTH = 12


@dataclass(frozen=True, slots=True)
class Wish:
    """What a person wants to watch. `profile`: for thresholds; `record`: the file of all commands."""

    mission: Path
    endpoints: Sequence[str]
    record: Path
    certificates: Path | None = None
    profile: Path | None = None


class Watch:
    """A checked wish; InputError before anything is opened."""

    def __init__(self, wish: Wish) -> None:
        self.mission: Mission = load_mission(wish.mission)
        self.thresholds: Thresholds = thresholds_of(None if wish.profile is None else load_profile(wish.profile))
        check_connect_option(wish.endpoints, wish.certificates)
        self._membership: Membership | None = membership_of(self.mission, wish.certificates)
        self._digest = hashlib.sha256(wish.mission.read_bytes()).hexdigest()[:DIGEST_LENGTH]
        self._wish = wish
        self._clock = SystemClock()

    async def show(self) -> None:
        """In the terminal, until the person quits."""
        async with self.opened() as source:
            app = WatchApp(source, self._clock)
            await app.run_async()
            await app.all_sent()

    async def tell(self, say: Callable[[Overview], None]) -> None:
        """`say` once a second until cancelled."""
        async with self.opened() as source:
            due_s = self._clock.now_s() + LINE_PERIOD_S
            while True:
                await asyncio.sleep(POLL_PERIOD_S)
                overview = source.look()
                if overview.now_s >= due_s:
                    due_s += LINE_PERIOD_S
                    say(overview)

    async def once(self) -> Overview:
        """As soon as every vehicle is heard and its clock known, or ONCE_TIMEOUT_S have passed."""
        async with self.opened() as source:
            deadline_s = self._clock.now_s() + ONCE_TIMEOUT_S
            while True:
                await asyncio.sleep(POLL_PERIOD_S)
                overview = source.look()
                if overview.now_s >= deadline_s or all(row.link is not Link.NEVER and row.offset for row in overview.rows):
                    return overview

    @asynccontextmanager
    async def opened(self) -> AsyncIterator[Source]:
        """The source of a view, while the session is open."""
        fleet, names = self.mission.fleet, tuple(vehicle.name for vehicle in self.mission.vehicles)
        session = await open_session([], self._wish.endpoints, wait_for_peers=False, membership=self._membership)
        listener = FleetListener(session, fleet, names, self._clock)
        model = FleetModel(self.mission, self._digest, self.thresholds)
        commander = Commander(session, fleet, self._clock, self._wish.record)
        asking = asyncio.create_task(listener.run())
        try:
            yield Source(
                self.mission,
                tuple(self._wish.endpoints),
                self.thresholds,
                lambda: model.look(listener.poll()),
                commander.send,
            )
        finally:
            asking.cancel()
            await asyncio.to_thread(session.close)

"""The other machines' clocks as one vehicle measures them: stamps are corrected by it, recordings are merged by it."""

from __future__ import annotations

from flightapp.fleet.clock_watch import ClockWatch
from flightapp.runtime.rooms import Rooms

TOLD_AGAIN_S = 0.02
"""A change of an offset that is an event of its own."""
RECORD_PERIOD_S = 1.0


class FleetTime:
    """Polled by the control loop; `ask` is a task beside it."""

    def __init__(self, rooms: Rooms) -> None:
        self._rooms = rooms
        self._watch = ClockWatch(rooms.team.post, rooms.clock)
        self._told: dict[str, float] = {}
        self._recorded_s = -RECORD_PERIOD_S

    async def ask(self) -> None:
        """Until cancelled."""
        await self._watch.run()

    def poll(self, now_s: float) -> None:
        """Take what was measured; an event for each offset that is new or another one, a record once a second."""
        self._watch.poll(now_s)
        for name, offset in self._watch.offsets.items():
            told_s = self._told.get(name)
            if told_s is None or abs(offset.ahead_s - told_s) > TOLD_AGAIN_S:
                self._told[name] = offset.ahead_s
                self._rooms.journal.clock_offset_changed(name, offset, self._told)
        if self._watch.offsets and now_s - self._recorded_s >= RECORD_PERIOD_S:
            self._recorded_s = now_s
            self._rooms.journal.clock_offsets(self._watch.offsets, now_s)

"""Commands with an acknowledgement: started here, answered on MAVSDK's thread, waited for without blocking anything."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

from flightapp.core.clock import Clock
from flightapp.core.errors import FlightError

COMMAND_TIMEOUT_S = 5.0
COMPLAINT_DELAY_S = 0.1
"""The reason of a refusal comes as a status text beside the acknowledgement."""
COMPLAINT_AGE_MAX_S = 3.0

Start = Callable[[Callable[..., object]], None]
"""Starts a MAVSDK command that calls its argument with the result when the acknowledgement has come."""


class Commands:
    """complaints: the autopilot's warnings and errors since a time, in words."""

    def __init__(self, clock: Clock, complaints: Callable[[float], list[str]]) -> None:
        self._clock = clock
        self._complaints = complaints

    async def run(self, what: str, start: Start) -> None:
        """Until acknowledged; FlightError with the autopilot's result and status texts when it is refused or not answered.

        A cancelled wait does not cancel the command: an autopilot that was only slow may still execute it.
        """
        loop = asyncio.get_running_loop()
        answer: asyncio.Future[Any] = loop.create_future()

        def resolve(result: Any) -> None:
            if not answer.done():
                answer.set_result(result)

        start(lambda result, *_: loop.call_soon_threadsafe(resolve, result))
        try:
            result = await asyncio.wait_for(answer, COMMAND_TIMEOUT_S)
        except TimeoutError:
            raise FlightError(f"autopilot gave no answer to '{what}' within {COMMAND_TIMEOUT_S:g} s") from None
        if result.name != "SUCCESS":
            await asyncio.sleep(COMPLAINT_DELAY_S)
            reasons = "; ".join(self._complaints(self._clock.now_s() - COMPLAINT_AGE_MAX_S))
            raise FlightError(f"autopilot refused '{what}': {result.name}{f' ({reasons})' if reasons else ''}")

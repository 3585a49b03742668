"""One operator command to a fleet: join the network, ask, collect who answered and who did not."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence

from flightapp.config.profile import check_endpoint
from flightapp.core.clock import SystemClock
from flightapp.core.errors import InputError
from flightapp.fleet.messages import COMMANDS, Acknowledgement
from flightapp.fleet.operator import Operator
from flightapp.fleet.session import open_session

CONNECT_TIMEOUT_S = 3.0


async def send_command(
    action: str, fleet: str, names: Sequence[str], vehicle: str | None, endpoints: Sequence[str]
) -> list[Acknowledgement]:
    """The answer of every vehicle that was asked; one that was not reached answers 'not reached'."""
    if action not in COMMANDS:
        raise InputError(f"command '{action}': must be one of {', '.join(COMMANDS)}")
    if vehicle is not None and vehicle not in names:
        raise InputError(f"--vehicle {vehicle}: no vehicle of the mission is called so; known: {', '.join(names)}")
    for endpoint in endpoints:
        try:
            check_endpoint(endpoint)
        except ValueError as error:
            raise InputError(f"--connect {error}") from None
    clock = SystemClock()
    asked = set(names if vehicle is None else [vehicle])
    session = await open_session([], endpoints)
    try:
        operator = Operator(session, fleet, names, clock)
        deadline = clock.now_s() + CONNECT_TIMEOUT_S
        answers: dict[str, Acknowledgement] = {}
        while asked - answers.keys() and clock.now_s() < deadline:
            for answer in await operator.command(action, vehicle, timeout_s=1.0):
                answers[answer.vehicle] = answer
            await asyncio.sleep(0.05)
    finally:
        await asyncio.to_thread(session.close)
    missing = [Acknowledgement(name, "", False, "not reached") for name in sorted(asked - answers.keys())]
    return [*answers.values(), *missing]

"""One operator command to a fleet: join the network, ask, tell who answered and who did not, and leave a record."""

from __future__ import annotations

import asyncio
import sys
import uuid
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from flightapp.config.mission import Mission
from flightapp.config.profile import check_endpoint, check_endpoints_are_secure
from flightapp.core.clock import Clock, SystemClock
from flightapp.core.errors import InputError
from flightapp.fleet.audit import append_record, operator_name
from flightapp.fleet.messages.command import COMMANDS, Command
from flightapp.fleet.operator import Answer, Operator
from flightapp.fleet.security.access import membership_of
from flightapp.fleet.session import open_session


@dataclass(frozen=True, slots=True)
class Wish:
    """What an operator wants of whom. `vehicle` None: all of the mission; `record`: the file of all commands."""

    action: str
    vehicle: str | None
    endpoints: Sequence[str]
    timeout_s: float
    record: Path
    certificates: Path | None = None
    """The operator's folder from `flightapp keys`, for a fleet that has certificates."""


def new_command(action: str, clock: Clock) -> Command:
    """A new wish of whoever runs this process: with an identifier of its own, also where it repeats an older one."""
    return Command(action, uuid.uuid4().hex, clock.now_s(), operator_name())


async def send_command(mission: Mission, wish: Wish, on_answer: Callable[[Answer], None]) -> list[Answer]:
    """The answers as they came, those of vehicles that did not answer last; each is given to `on_answer` at once.

    InputError for an unknown action or vehicle and a malformed endpoint: then nothing is sent.
    """
    asked = _checked(mission, wish)
    membership = membership_of(mission, wish.certificates)
    clock = SystemClock()
    session = await open_session([], wish.endpoints, wait_for_peers=False, membership=membership)
    command = new_command(wish.action, clock)
    answers: list[Answer] = []

    def take(answer: Answer) -> None:
        answers.append(answer)
        on_answer(answer)

    try:
        await Operator(session, mission.fleet, clock).send(command, asked, wish.timeout_s, take)
    finally:
        problem = append_record(wish.record, mission.fleet, command, asked, answers)
        if problem:
            sys.stderr.write(f"{problem}\n")
        await asyncio.to_thread(session.close)
    return answers


def _checked(mission: Mission, wish: Wish) -> list[str]:
    """Names of the vehicles to ask."""
    if wish.action not in COMMANDS:
        raise InputError(f"command '{wish.action}': must be one of {', '.join(COMMANDS)}")
    names = [vehicle.name for vehicle in mission.vehicles]
    if wish.vehicle is not None and wish.vehicle not in names:
        raise InputError(f"--vehicle {wish.vehicle}: no vehicle of the mission is called so; known: {', '.join(names)}")
    check_connect_option(wish.endpoints, wish.certificates)
    return names if wish.vehicle is None else [wish.vehicle]


def check_connect_option(endpoints: Sequence[str], certificates: Path | None) -> None:
    """InputError for what cannot be connected to."""
    for endpoint in endpoints:
        try:
            check_endpoint(endpoint)
            check_endpoints_are_secure([endpoint], certificates)
        except ValueError as error:
            raise InputError(f"--connect {error}") from None

"""The operator's side of the fleet: one wish to several vehicles at once, each asked by itself until it answers.

A vehicle that is dead or frozen delays nobody: every vehicle has its own question on its own key. A question that gets no answer
(a packet lost over UDP, a link that is only coming up) is asked again under the same identifier, which a vehicle obeys once.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import zenoh

from flightapp.core.clock import Clock
from flightapp.fleet.messages.codec import MalformedPayloadError
from flightapp.fleet.messages.command import Command, decode_acknowledgement, encode_command
from flightapp.fleet.messages.keys import command_key

ASK_AGAIN_S = 0.25
"""Several control periods: a vehicle that flies answers in its next one."""
OUT_OF_TIME = b"Timeout"
"""What Zenoh itself answers in the place of a vehicle that does not."""
LINK_COMING_UP_S = 0.01
"""A vehicle that the session does not know yet ends the question at once."""


@dataclass(frozen=True, slots=True)
class Answer:
    """Of one vehicle; `round_trip_s` from the first time of asking to the answer, None without one."""

    vehicle: str
    accepted: bool
    text: str
    round_trip_s: float | None


def _nobody(_answer: Answer) -> None:
    """Nobody looks on."""


class Operator:
    """Sends commands through `session`."""

    def __init__(self, session: zenoh.Session, fleet: str, clock: Clock) -> None:
        self._session = session
        self._fleet = fleet
        self._clock = clock

    async def send(
        self, command: Command, vehicles: Iterable[str], timeout_s: float, on_answer: Callable[[Answer], None] = _nobody
    ) -> list[Answer]:
        """The answers in the order in which they came, then who did not answer within `timeout_s`.

        on_answer: called with each answer as it comes.
        """
        names = list(vehicles)
        began_s = self._clock.now_s()
        answers: list[Answer] = []

        async def ask(vehicle: str) -> None:
            accepted, text = await self._ask_until_answered(command, vehicle)
            answers.append(Answer(vehicle, accepted, text, self._clock.now_s() - began_s))
            on_answer(answers[-1])

        asking = [asyncio.create_task(ask(name)) for name in names]
        _, silent = await asyncio.wait(asking, timeout=timeout_s)
        for task in silent:
            task.cancel()
        await asyncio.gather(*silent, return_exceptions=True)
        heard = {answer.vehicle for answer in answers}
        for name in sorted(set(names) - heard):
            text = f"no answer within {timeout_s:g} s: it is off, hangs, or its endpoint is not among those connected to"
            answers.append(Answer(name, False, text, None))
            on_answer(answers[-1])
        return answers

    async def _ask_until_answered(self, command: Command, vehicle: str) -> tuple[bool, str]:
        while (answer := await self._ask(command, vehicle)) is None:
            await asyncio.sleep(LINK_COMING_UP_S)
        return answer

    async def _ask(self, command: Command, vehicle: str) -> tuple[bool, str] | None:
        """One question: (accepted, text), or None where it ended without an answer to it."""
        loop = asyncio.get_running_loop()
        answer: asyncio.Future[tuple[bool, str] | None] = loop.create_future()

        def settle(value: tuple[bool, str] | None) -> None:
            if not answer.done():
                answer.set_result(value)

        def take(reply: zenoh.Reply) -> None:
            said = _said(reply, command, vehicle)
            if said is not None:
                loop.call_soon_threadsafe(settle, said)

        self._session.get(
            command_key(self._fleet, vehicle),
            zenoh.handlers.Callback(take, lambda: loop.call_soon_threadsafe(settle, None)),
            payload=encode_command(command),
            target=zenoh.QueryTarget.ALL,
            timeout=ASK_AGAIN_S,
        )
        return await answer


def _said(reply: zenoh.Reply, command: Command, vehicle: str) -> tuple[bool, str] | None:
    """What a reply says to `command`; None where it belongs to something else."""
    if reply.ok is None:
        refusal = b"" if reply.err is None else reply.err.payload.to_bytes()
        return None if refusal in (b"", OUT_OF_TIME) else (False, refusal.decode(errors="replace"))
    try:
        acknowledgement = decode_acknowledgement(reply.ok.payload.to_bytes())
    except MalformedPayloadError as error:
        return False, f"its answer cannot be read: {error}"
    if acknowledgement.vehicle != vehicle or acknowledgement.identifier != command.identifier:
        return None
    return acknowledgement.accepted, acknowledgement.text

"""Sends what a person confirmed, and leaves the record that `flightapp command` leaves."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import zenoh

from flightapp.core.clock import Clock
from flightapp.fleet.audit import append_record
from flightapp.fleet.command import new_command
from flightapp.fleet.operator import Answer, Operator
from flightapp.watch.data_model_confirmation import Order

ANSWER_TIMEOUT_S = 3.0


class Commander:
    """The operator's side of `session`."""

    def __init__(self, session: zenoh.Session, fleet: str, clock: Clock, record: Path) -> None:
        self._operator = Operator(session, fleet, clock)
        self._fleet, self._clock, self._record = fleet, clock, record

    async def send(self, order: Order, on_answer: Callable[[Answer], None]) -> str:
        """Empty, or one sentence why it is not on record. Each answer is given to `on_answer` as it comes."""
        command = new_command(order.action, self._clock)
        answers: list[Answer] = []

        def take(answer: Answer) -> None:
            answers.append(answer)
            on_answer(answer)

        try:
            await self._operator.send(command, order.vehicles, ANSWER_TIMEOUT_S, take)
        finally:
            problem = append_record(self._record, self._fleet, command, order.vehicles, answers)
        return problem

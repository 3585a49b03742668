"""A command is sent at the second press of its key: the first one asks."""

from __future__ import annotations

from dataclasses import dataclass

CONFIRM_WITHIN_S = 3.0


@dataclass(frozen=True, slots=True)
class Order:
    """A command of `flightapp.fleet.messages.command` to these vehicles."""

    action: str
    vehicles: tuple[str, ...]


class Confirmation:
    """Only the same order again, in time, confirms; anything else asks anew."""

    def __init__(self, within_s: float = CONFIRM_WITHIN_S) -> None:
        self._within_s = within_s
        self._asked: Order | None = None
        self._until_s = 0.0

    def press(self, order: Order, now_s: float) -> bool:
        """True: send it. False: it was asked for."""
        if self.asked(now_s) == order:
            self._asked = None
            return True
        self._asked, self._until_s = order, now_s + self._within_s
        return False

    def asked(self, now_s: float) -> Order | None:
        """What a second press would send."""
        if self._asked is not None and now_s > self._until_s:
            self._asked = None
        return self._asked

    def cancel(self) -> None:
        self._asked = None

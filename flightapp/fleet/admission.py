"""Which of the messages that one vehicle sends on one key are taken: newer ones, none from the future, none that are too late."""

from __future__ import annotations

from enum import Enum

from flightapp.fleet.messages.codec import Header

FUTURE_TOLERANCE_S = 0.2
"""What clocks may still differ after correction."""


class Verdict(Enum):
    """Of one message."""

    TAKEN = "taken"
    REPEATED = "repeated"
    REORDERED = "reordered"
    LATE = "late"
    FUTURE = "stamped in the future"


class Admission:
    """Judges one sender's messages of one kind, in the order in which they arrive.

    Order is judged by the sender's own, uncorrected stamps: its clock never steps back while its process lives, the measured
    correction may. After a silence of the greatest age that is taken and the tolerance, the sender may be a new process, whose
    clock and counting begin anew: whatever it sent before would be too late by then.
    """

    def __init__(self, age_max_s: float) -> None:
        self._age_max_s = age_max_s
        self.newest: Header | None = None
        """Of the last message that was taken, corrected."""
        self.lost = 0
        """Numbers that are missing between messages taken."""
        self.counts = dict.fromkeys(Verdict, 0)
        self.ahead_s = 0.0
        """How far the newest message, taken or not, was stamped ahead of the own clock."""
        self._raw_s = 0.0
        self._sequence_of: dict[bool, int] = {}
        self._taken_s = 0.0

    @property
    def rejected(self) -> int:
        return sum(self.counts.values()) - self.counts[Verdict.TAKEN]

    def judge(self, header: Header, clock_ahead_s: float, now_s: float, *, addressed: bool = False) -> Verdict:
        """Count the message with `header`, corrected by `clock_ahead_s`, that was received at `now_s`.

        addressed: it was for this machine alone. Those are numbered by themselves.
        """
        verdict = self._judge(header, header.sent_s + clock_ahead_s, now_s, addressed)
        self.counts[verdict] += 1
        return verdict

    def _judge(self, header: Header, raw_s: float, now_s: float, addressed: bool) -> Verdict:
        self.ahead_s = header.sent_s - now_s
        if self.ahead_s > FUTURE_TOLERANCE_S:
            return Verdict.FUTURE
        if -self.ahead_s > self._age_max_s:
            return Verdict.LATE
        newest = self.newest
        if newest is not None and now_s - self._taken_s <= self._age_max_s + FUTURE_TOLERANCE_S and raw_s <= self._raw_s:
            return Verdict.REPEATED if header.sequence == self._sequence_of.get(addressed) else Verdict.REORDERED
        self.lost += max(0, header.sequence - self._sequence_of.get(addressed, header.sequence) - 1)
        self._sequence_of[addressed] = header.sequence
        self.newest, self._raw_s, self._taken_s = header, raw_s, now_s
        return Verdict.TAKEN

"""Conditions that come and go at frame rate, told to a person once when they come and once when they are over."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

OVER_AFTER_S = 1.0
"""A condition that has not held for this long is over: one that flickers is one condition."""
_NUMBER = re.compile(r"\d+(\.\d+)?")


@dataclass(frozen=True, slots=True)
class Notice:
    """One line for the recording: `level` is info or warning."""

    level: str
    text: str


@dataclass(slots=True)
class _Condition:
    text: str
    since_s: float
    last_s: float


class Conditions:
    """What is wrong now. Two sentences that differ only in their numbers are the same condition."""

    def __init__(self) -> None:
        self._holding: dict[str, _Condition] = {}

    def update(self, now_s: float, sentences: Iterable[str]) -> list[Notice]:
        """Changes, where `sentences` are what is wrong at `now_s`: a warning for each new one, an info for each that ended."""
        notices = []
        for sentence in sentences:
            key = _NUMBER.sub("#", sentence)
            known = self._holding.get(key)
            if known is None:
                self._holding[key] = _Condition(sentence, now_s, now_s)
                notices.append(Notice("warning", sentence))
            else:
                known.last_s = now_s
        for key, condition in list(self._holding.items()):
            if now_s - condition.last_s >= OVER_AFTER_S:
                del self._holding[key]
                lasted_s = condition.last_s - condition.since_s
                notices.append(Notice("info", f"over after {lasted_s:.1f} s: {condition.text}"))
        return notices

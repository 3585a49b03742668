"""One time base for all recordings of a run, by the clock offsets that the vehicles measured in flight.

Every recording may hold the metadata `clock_offsets`: name of another vehicle -> seconds that its clock is ahead of the own.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from flightapp.recording.reader import Recording

METADATA = "clock_offsets"

Source = Literal["reference", "measured", "not measured", "only recording"]


@dataclass(frozen=True, slots=True)
class Shift:
    """What is added to the times of one recording, and on what grounds."""

    shift_s: float
    source: Source


def shifts_of(recordings: Sequence[Recording]) -> dict[str, Shift]:
    """By vehicle. The clock of the first vehicle that can be reached from most of the others is the run's time base.

    Offsets are followed from vehicle to vehicle; a vehicle that none leads to keeps its own times.
    """
    names = [recording.vehicle for recording in recordings]
    if len(names) == 1:
        return {names[0]: Shift(0.0, "only recording")}
    ahead_s = _ahead_s(recordings)
    shifts = {name: Shift(0.0, "not measured") for name in names}
    reached = max((_reached(name, names, ahead_s) for name in names), key=len, default={})
    if len(reached) > 1:
        reference, *others = reached
        shifts[reference] = Shift(0.0, "reference")
        shifts |= {name: Shift(0.0 - reached[name], "measured") for name in others}
    return shifts


def _reached(start: str, names: Sequence[str], ahead_s: Mapping[tuple[str, str], float]) -> dict[str, float]:
    """How far the clock of each vehicle that measurements lead to is ahead of that of `start`, by the fewest steps."""
    found = {start: 0.0}
    waiting = deque([start])
    while waiting:
        here = waiting.popleft()
        for name in names:
            if name not in found and (here, name) in ahead_s:
                found[name] = found[here] + ahead_s[here, name]
                waiting.append(name)
    return found


def _ahead_s(recordings: Sequence[Recording]) -> dict[tuple[str, str], float]:
    """(a, b) -> how far b's clock is ahead of a's: as a measured it, the mean where b measured it too."""
    told: dict[tuple[str, str], list[float]] = {}
    for recording in recordings:
        for peer, text in recording.metadata.get(METADATA, {}).items():
            offset_s = _seconds(text)
            if offset_s is not None:
                told.setdefault((recording.vehicle, peer), []).append(offset_s)
                told.setdefault((peer, recording.vehicle), []).append(-offset_s)
    return {pair: sum(values) / len(values) for pair, values in told.items()}


def _seconds(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None

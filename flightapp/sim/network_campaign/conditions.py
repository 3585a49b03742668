"""The links that a campaign flies over: a grid of delay and loss, and partitions that heal."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

from flightapp.core.errors import InputError
from flightapp.sim.link_shaper import LinkQuality

PartitionKind = Literal["none", "one", "halves"]
JITTER_SHARE = 0.5
DELAY_MAX_MS, LOSS_MAX_PERCENT = 2000.0, 90.0


@dataclass(frozen=True, slots=True, order=True)
class Condition:
    """One kind of network; `partition`: who is cut off for a while, `one` pursuer or one of two `halves`."""

    partition: PartitionKind
    delay_ms: float
    loss_percent: float

    @property
    def jitter_ms(self) -> float:
        return self.delay_ms * JITTER_SHARE

    @property
    def quality(self) -> LinkQuality:
        return LinkQuality(self.delay_ms * 1e-3, self.jitter_ms * 1e-3, self.loss_percent * 1e-2)


def parse_grid(delays_ms: str, losses_percent: str, partitions: str) -> tuple[Condition, ...]:
    """Every delay with every loss for the first partition named, best and worst corner for each other; InputError on bad text."""
    delays = _numbers("--delays-ms", delays_ms, DELAY_MAX_MS)
    losses = _numbers("--losses", losses_percent, LOSS_MAX_PERCENT)
    kinds = _partitions(partitions)
    corners = sorted({(delays[0], losses[0]), (delays[-1], losses[-1])})
    grid = [Condition(kinds[0], delay, loss) for delay in delays for loss in losses]
    return tuple(grid + [Condition(kind, delay, loss) for kind in kinds[1:] for delay, loss in corners])


def _numbers(option: str, text: str, most: float) -> list[float]:
    values = set()
    for part in text.split(","):
        if not re.fullmatch(r"\d{1,4}(\.\d+)?", part.strip()) or float(part) > most:
            raise InputError(f"{option} {text}: '{part.strip()}' is not a number from 0 to {most:g}; write them like 5,50,200")
        values.add(float(part))
    return sorted(values)


def _partitions(text: str) -> list[PartitionKind]:
    known: tuple[PartitionKind, ...] = get_args(PartitionKind)
    kinds: list[PartitionKind] = []
    for part in text.split(","):
        kind = next((one for one in known if one == part.strip()), None)
        if kind is None:
            raise InputError(f"--partitions {text}: '{part.strip()}' is none of {', '.join(known)}")
        if kind not in kinds:
            kinds.append(kind)
    return kinds


def side_of(kind: PartitionKind, pursuers: Sequence[str], evaders: Sequence[str]) -> tuple[str, ...]:
    """Who is cut off from the rest: the last pursuer; or the first half of the pursuers, the evader with the other half."""
    if kind == "none":
        return ()
    return tuple(pursuers[-1:]) if kind == "one" else tuple(pursuers[: len(pursuers) // 2] or evaders)

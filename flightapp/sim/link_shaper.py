"""What a radio link does to packets: delay, jitter, loss, partition and healing. Deterministic by seed, without clock or sockets.

One shaper serves the virtual network, the UDP proxy and the network namespaces, so that their figures can be compared.
"""

from __future__ import annotations

import random
from collections.abc import Collection
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class LinkQuality:
    """Of every link, each way. The delay of a packet is uniform in `delay_s` +- `jitter_s`, so jitter also reorders.

    loss: probability that a packet vanishes, independent of the others.
    """

    delay_s: float = 0.005
    jitter_s: float = 0.0
    loss: float = 0.0

    def __post_init__(self) -> None:
        """ValueError where no link could be like that."""
        if not 0.0 <= self.jitter_s <= self.delay_s:
            raise ValueError(f"jitter of {self.jitter_s:g} s: must be between 0 and the delay, {self.delay_s:g} s")
        if not 0.0 <= self.loss < 1.0:
            raise ValueError(f"loss of {self.loss:g}: must be at least 0 and less than 1")


class LinkShaper:
    """Decides for each packet. Each direction of each link has numbers of its own: what one sends does not change another's luck.

    With equal seeds more loss loses the same packets and more, which makes campaigns over loss comparable seed by seed.
    """

    def __init__(self, quality: LinkQuality, seed: int) -> None:
        self.quality = quality
        self._seed = seed
        self._chances: dict[tuple[str, str], random.Random] = {}
        self._side: frozenset[str] = frozenset()

    def split(self, side: Collection[str]) -> None:
        """Nothing passes between `side` and the rest any more."""
        self._side = frozenset(side)

    def heal(self) -> None:
        self._side = frozenset()

    def is_cut(self, sender: str, receiver: str) -> bool:
        return (sender in self._side) != (receiver in self._side)

    def delay_s(self, sender: str, receiver: str) -> float | None:
        """How long the next packet of `sender` to `receiver` takes; None where it never arrives."""
        chance = self._chances.get((sender, receiver))
        if chance is None:
            chance = self._chances[sender, receiver] = random.Random(f"link {self._seed} {sender} {receiver}")
        lost, late = chance.random() < self.quality.loss, chance.uniform(-1.0, 1.0)
        if lost or self.is_cut(sender, receiver):
            return None
        return self.quality.delay_s + late * self.quality.jitter_s

"""A fleet of real election cores, in true time, over a network that may do anything; the clocks of its members drift."""

from __future__ import annotations

from dataclasses import dataclass, field
from random import Random

from flightapp.fleet.election.beacon import Beacon, Role
from flightapp.fleet.election.core import Election
from flightapp.fleet.election.memory import Memory
from flightapp.fleet.election.timing import Timing

TICK_S = 0.04
TIMING = Timing()


@dataclass
class Ether:
    """`rates` and `offsets_s` make each member's clock from true time."""

    rates: tuple[float, ...]
    offsets_s: tuple[float, ...]
    seed: int
    loss: float = 0.0
    delay_s: tuple[float, float] = (0.0, 0.0)
    repeats: float = 0.0
    cut: set[tuple[str, str]] = field(default_factory=set)
    """(sender, listener) pairs that do not hear."""
    now_s: float = 0.0

    def __post_init__(self) -> None:
        self.names = tuple(f"p{1 + index}" for index in range(len(self.rates)))
        self._random = Random(self.seed)
        self._air: list[tuple[float, str, str, Beacon]] = []
        self.stored = {name: Memory() for name in self.names}
        self.alive: dict[str, Election] = {}
        self.reigns: dict[int, str] = {}
        for name in self.names:
            self.restart(name)

    def clock_s(self, name: str) -> float:
        index = self.names.index(name)
        return self.offsets_s[index] + self.rates[index] * self.now_s

    def restart(self, name: str) -> None:
        self.alive[name] = Election(name, self.names, TIMING, self.clock_s(name), self.stored[name], seed=self.seed)

    def crash(self, name: str) -> None:
        self.alive.pop(name, None)

    def make_whole(self) -> None:
        """Everybody is up and hears everybody after at most 20 ms."""
        self.loss, self.delay_s, self.repeats = 0.0, (0.0, 0.02), 0.0
        self.cut.clear()
        self._air.clear()
        for name in self.names:
            if name not in self.alive:
                self.restart(name)

    def pass_time(self, duration_s: float, held_up: frozenset[str] = frozenset()) -> None:
        """Members that are held up do not step, but may speak when asked."""
        end_s = self.now_s + duration_s
        while self.now_s < end_s - 1e-9:
            self.now_s += TICK_S
            self._check_voices()
            for name in self._random.sample(sorted(self.alive), len(self.alive)):
                if name not in held_up:
                    self._step(name)
                    self._check_voices()

    def voices(self) -> list[str]:
        """Who may speak for the fleet now."""
        return [name for name, member in self.alive.items() if member.is_leader(self.clock_s(name))]

    def is_settled(self) -> bool:
        """One may speak, and all that are up follow it."""
        voices = self.voices()
        return len(voices) == 1 and {member.leader for member in self.alive.values()} == set(voices)

    def settle(self, within_s: float) -> float:
        """How long it takes until one leads all; more than `within_s` where it does not."""
        since_s = self.now_s
        while not self.is_settled() and self.now_s - since_s <= within_s:
            self.pass_time(TICK_S)
        return self.now_s - since_s

    def _step(self, name: str) -> None:
        member, before = self.alive[name], self.alive[name].memory
        due = [heard for heard in self._air if heard[1] == name and heard[0] <= self.now_s]
        self._air = [heard for heard in self._air if heard not in due]
        self._random.shuffle(due)
        sent = member.step(self.clock_s(name), [(sender, beacon) for _, _, sender, beacon in due])
        after = self.stored[name] = member.memory
        assert after.term >= before.term, "terms never go back"
        assert after.term > before.term or before.vote in (None, after.vote), "one vote a term"
        if member.role is Role.LEADER:
            assert self.reigns.setdefault(member.term, name) == name, "one leader a term"
        for beacon in sent:
            for listener in self.names:
                if listener != name and (name, listener) not in self.cut and self._random.random() >= self.loss:
                    for _ in range(1 + (self._random.random() < self.repeats)):
                        self._air.append((self.now_s + self._random.uniform(*self.delay_s), listener, name, beacon))

    def _check_voices(self) -> None:
        assert len(self.voices()) <= 1, "one voice at a time"

"""Every schedule of a small fleet, breadth first, with the real core.

    python -m flightapp.fleet.election.model --nodes 3 --depth 7

What happens between two situations is one of:

- one period of time passes, and all members step, or all but one, whose process is held up;
- one member hears one beacon: any of the last ones of any other member, in any order, any number of times or never, which is
  loss, delay, duplication, reordering and every partition, also one of one direction only;
- one member crashes, or a crashed one restarts with what it had stored.

Clocks drift: each in turn runs slow by the largest drift while all others run fast, which is the worst for its lease; and all run
true. Situations that differ only by what can have no effect any more are one: times count from the own present, what is older
than a lease is left out. Each is known by 64 bits of its hash, as model checkers do (Wolper and Leroy, Reliable Hashing without
Collision Detection, 1993).

In every situation: no term ever had two leaders, no term went back, at most one member may speak. From every `HEALED_EACH`th a
copy goes on with all members up and nothing lost, and must come to one leader whom all follow within `HEALING_MAX_S`.
"""

from __future__ import annotations

import argparse
import marshal
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from flightapp.fleet.election.beacon import Beacon, Role
from flightapp.fleet.election.core import Election
from flightapp.fleet.election.memory import Memory
from flightapp.fleet.election.timing import Timing

TIMING = Timing(beacon_period_s=1.0, lease_s=2.4, timeout_min_s=3.0, timeout_max_s=4.5, clock_drift_max=0.1)
"""One beacon period is the unit of time; lease and timeout are as near to each other as the drift allows."""
HEARD_LATE = 2
"""So many of a member's last beacons may still be heard."""
HEALED_EACH = 50
HEALING_MAX_S = 4.0 * TIMING.timeout_max_s
STARTS = ("cold", "settled", "all seeking", "rivals", "one parted", "leader late")
NAMES = ("p1", "p2", "p3", "p4", "p5")

Make = Callable[[str, Sequence[str], Timing, float, Memory], Election]


class RuleBrokenError(AssertionError):
    """A situation in which the election's promise does not hold, with the shortest schedule that leads there."""


@dataclass(frozen=True, slots=True)
class Situation:
    """A fleet at one moment. Members are never changed in place."""

    members: tuple[Election | Memory, ...]
    """A crashed member is what it had stored."""
    air: tuple[tuple[Beacon, ...], ...]
    """Of each member the last beacons, newest last."""
    t_s: float
    crashes_left: int
    reigns: tuple[tuple[int, str], ...]
    """Every (term, leader) so far."""


Story = tuple[tuple[object, ...], ...]
"""What happened, step by step."""


@dataclass(slots=True)
class _Node:
    """A situation with a shortest way to it."""

    situation: Situation
    ages: tuple[bytes, ...]
    story: Story
    ways: int
    """How many shortest schedules lead to it."""


@dataclass(slots=True)
class Explored:
    """What a search has seen."""

    situations: int = 0
    transitions: int = 0
    schedules: int = 0
    """Different shortest ways to the situations of the last depth."""
    depth: int = 0
    healed: int = 0
    healing_max_s: float = 0.0
    term_max: int = 0

    def add(self, other: Explored) -> None:
        self.situations += other.situations
        self.transitions += other.transitions
        self.schedules += other.schedules
        self.depth = other.depth
        self.healed += other.healed
        self.healing_max_s = max(self.healing_max_s, other.healing_max_s)
        self.term_max = max(self.term_max, other.term_max)


class Model:
    """Fleets of `nodes` members whose clocks run at `rates`; `make` builds a member, the real one or a broken one."""

    def __init__(self, rates: Sequence[float], make: Make = Election, heard_late: int = HEARD_LATE) -> None:
        self._names = NAMES[: len(rates)]
        self._rates = tuple(rates)
        self._make = make
        self._timing = TIMING
        self._heard_late = heard_late

    def start(self, crashes: int) -> dict[str, Situation]:
        """Where the searches begin: quiet ones, and those in which the least must happen until something may go wrong."""
        members = tuple(self._make(name, self._names, self._timing, 0.0, Memory()) for name in self._names)
        cold = Situation(members, ((),) * len(members), 0.0, crashes, ())
        settled, _ = self._heal(cold)
        everybody, loner = set(range(len(members))), (_leader_index(settled) + 1) % len(members)
        seeking = cold
        for _ in range(5):
            seeking = self._pass_time(seeking, held_up=None)
        seeking = self._pass_time(self._exchange(seeking, everybody), held_up=None)
        rivals = self._exchange(seeking, {0, 1} if len(members) > 1 else {0}, among=everybody)
        parted = settled
        for _ in range(5):
            parted = self._pass_time(parted, held_up=None)
            parted = self._exchange(self._exchange(parted, everybody - {loner}), everybody - {loner})
        late = self._pass_time(self._pass_time(parted, held_up=None), held_up=None)
        return dict(zip(STARTS, (cold, settled, seeking, rivals, parted, late), strict=True))

    def explore(
        self, depth: int, crashes: int, situations_max: int, starts: Collection[str] = STARTS, heals: bool = True
    ) -> Explored:
        """All schedules of at most `depth` transitions; it ends earlier, between two depths, at `situations_max` situations."""
        seen: set[int] = set()
        layer: list[_Node] = []
        explored = Explored()
        for name, situation in self.start(crashes).items():
            ages = self._ages(situation)
            if name in starts and hash(ages) not in seen:
                seen.add(hash(ages))
                layer.append(_Node(situation, ages, ((f"from '{name}'",),), 1))
                self._check(situation, situation, layer[-1].story)
        while explored.depth < depth and layer and len(seen) < situations_max:
            found: dict[int, _Node] = {}
            for node in layer:
                for what, following in self._following(node.situation):
                    explored.transitions += 1
                    ages = self._ages(following, node)
                    code = hash(ages)
                    if code in found:
                        found[code].ways += node.ways
                    elif code not in seen:
                        seen.add(code)
                        found[code] = _Node(following, ages, (*node.story, what), node.ways)
                        self._check(node.situation, following, found[code].story)
                        if heals and len(seen) % HEALED_EACH == 0:
                            self._check_healing(found[code], explored)
            layer = list(found.values())
            explored.depth += 1
        explored.situations = len(seen)
        explored.schedules = sum(node.ways for node in layer)
        explored.term_max = max((one.term for node in layer for one in node.situation.members), default=0)
        return explored

    def _following(self, at: Situation) -> Iterator[tuple[tuple[object, ...], Situation]]:
        yield ("time passes",), self._pass_time(at, held_up=None)
        for index, member in enumerate(at.members):
            name = self._names[index]
            if isinstance(member, Memory):
                back = self._make(name, self._names, self._timing, self._now_s(at, index), member)
                yield (name, "restarts"), self._changed(at, index, back, ())
                continue
            yield ("time passes,", name, "is held up"), self._pass_time(at, held_up=index)
            if at.crashes_left:
                yield (name, "crashes"), replace(self._changed(at, index, member.memory, ()), crashes_left=at.crashes_left - 1)
            for sender, beacons in enumerate(at.air):
                for beacon in beacons if sender != index else ():
                    heard = self._step(at, index, ((self._names[sender], beacon),))
                    yield (name, "hears", self._names[sender], beacon), heard

    def _pass_time(self, at: Situation, held_up: int | None) -> Situation:
        later = replace(at, t_s=at.t_s + 1.0)
        for index, member in enumerate(at.members):
            if index != held_up and isinstance(member, Election):
                later = self._step(later, index, ())
        return later

    def _step(self, at: Situation, index: int, inbox: tuple[tuple[str, Beacon], ...]) -> Situation:
        member = at.members[index]
        assert isinstance(member, Election)
        after = object.__new__(type(member))
        after.__dict__.update(member.__dict__)  # As copy.copy does, in a third of the time.
        return self._changed(at, index, after, after.step(self._now_s(at, index), inbox))

    def _changed(self, at: Situation, index: int, member: Election | Memory, sent: tuple[Beacon, ...]) -> Situation:
        members = (*at.members[:index], member, *at.members[index + 1 :])
        air, reigns = at.air, at.reigns
        if sent and sent[-1:] != air[index][-1:]:
            air = (*air[:index], (*air[index], *sent)[-self._heard_late :], *air[index + 1 :])
        if isinstance(member, Election) and member.role is Role.LEADER and (member.term, member.name) not in reigns:
            reigns = tuple(sorted((*reigns, (member.term, member.name))))
        return Situation(members, air, at.t_s, at.crashes_left, reigns)

    def _now_s(self, at: Situation, index: int) -> float:
        """The member's own time."""
        return at.t_s * self._rates[index]

    def _ages(self, at: Situation, before: _Node | None = None) -> tuple[bytes, ...]:
        """The same for situations from which the same can follow. What has not changed since `before` is taken from there."""
        shared = marshal.dumps((at.crashes_left, at.reigns), 2)
        if before is None or before.situation.t_s != at.t_s:
            return (shared, *(self._ages_of(at, index) for index in range(len(at.members))))
        was = before.situation
        same = (at.members[index] is was.members[index] and at.air[index] is was.air[index] for index in range(len(at.members)))
        return (shared, *(before.ages[i + 1] if is_same else self._ages_of(at, i) for i, is_same in enumerate(same)))

    def _ages_of(self, at: Situation, index: int) -> bytes:
        """One member, and what it has said."""
        member, now_s, oldest_s = at.members[index], self._now_s(at, index), self._timing.lease_s
        said = [
            (_rounded(min(oldest_s, now_s - beacon.stamp_s)), beacon.term, int(beacon.role), self._aged(at, beacon.backs))
            for beacon in at.air[index]
        ]
        if isinstance(member, Memory):
            return marshal.dumps((member.term, member.vote, said), 2)
        own = (
            (member.memory.term, member.memory.vote, int(member.role), member.leader, member._promised_to),
            _rounded(max(0.0, member._promised_until_s - now_s)),
            _rounded(max(0.0, member._patient_until_s - now_s)),
            _rounded(max(0.0, member._beacon_due_s - now_s)),
            _rounded(min(oldest_s, now_s - member._asking_since_s)),
            self._aged(at, member._backs.items()),
            sorted((name, _rounded(now_s - s)) for name, s in member._backers.items() if now_s - s < oldest_s),
        )
        return marshal.dumps((own, said), 2)

    def _aged(self, at: Situation, backs: Iterable[tuple[str, float]]) -> list[tuple[str, float]]:
        """Stamps of others as ages on their clocks; those older than a lease say nothing."""
        if not backs:
            return []
        ages = ((name, self._now_s(at, self._names.index(name)) - stamp_s) for name, stamp_s in backs)
        return sorted((name, _rounded(age_s)) for name, age_s in ages if age_s < self._timing.lease_s)

    def _check(self, before: Situation, at: Situation, story: Story) -> None:
        terms = [term for term, _ in at.reigns]
        if len(set(terms)) < len(terms):
            raise RuleBrokenError(_told("two leaders in one term", story))
        if any(after.term < member.term for member, after in zip(before.members, at.members, strict=True)):
            raise RuleBrokenError(_told("a term went back", story))
        speaking = [
            index for index, one in enumerate(at.members) if isinstance(one, Election) and one.is_leader(self._now_s(at, index))
        ]
        if len(speaking) > 1:
            raise RuleBrokenError(_told("two members may speak at the same time", story))

    def _check_healing(self, node: _Node, explored: Explored) -> None:
        healed, healing_s = self._heal(node.situation)
        if healing_s > HEALING_MAX_S:
            raise RuleBrokenError(_told(f"no leader {HEALING_MAX_S:g} s after the network was whole", node.story))
        self._check(node.situation, healed, node.story)
        explored.healed += 1
        explored.healing_max_s = max(explored.healing_max_s, healing_s)

    def _heal(self, at: Situation) -> tuple[Situation, float]:
        """All members up and hearing everything at once, until all follow one who may speak; and how long that took."""
        since_s = at.t_s
        for index, member in enumerate(at.members):
            if isinstance(member, Memory):
                back = self._make(self._names[index], self._names, self._timing, self._now_s(at, index), member)
                at = self._changed(at, index, back, ())
        everybody = set(range(len(at.members)))
        while not self._is_settled(at) and at.t_s - since_s <= HEALING_MAX_S:
            at = self._pass_time(at, held_up=None)
            for _ in range(4):
                at = self._exchange(at, everybody)
        return at, at.t_s - since_s

    def _exchange(self, at: Situation, listeners: set[int], among: set[int] | None = None) -> Situation:
        """`listeners` hear the newest beacons that all of `among`, or else of `listeners`, had sent before."""
        newest = [(self._names[index], at.air[index][-1]) for index in sorted(among or listeners) if at.air[index]]
        for index in sorted(listeners):
            at = self._step(at, index, tuple(heard for heard in newest if heard[0] != self._names[index]))
        return at

    def _is_settled(self, at: Situation) -> bool:
        leaders = {(one.leader, one.term) if isinstance(one, Election) else (None, 0) for one in at.members}
        speaks = any(isinstance(one, Election) and one.is_leader(self._now_s(at, i)) for i, one in enumerate(at.members))
        return len(leaders) == 1 and speaks


def drifting(nodes: int, drift: float) -> list[tuple[float, ...]]:
    """Rates of all clocks: all true, and each member's slow with all others fast."""
    rates = [(1.0,) * nodes]
    rates += [tuple(1.0 - drift if index == slow else 1.0 + drift for index in range(nodes)) for slow in range(nodes)]
    return rates


def _leader_index(at: Situation) -> int:
    return next((index for index, one in enumerate(at.members) if isinstance(one, Election) and one.role is Role.LEADER), 0)


def _rounded(duration_s: float) -> float:
    return round(duration_s, 6)


def _told(what: str, story: Story) -> str:
    return "\n  ".join((what, *(" ".join(map(str, step)) for step in story)))


def main(arguments: list[str] | None = None) -> None:
    """Explore and say what was seen."""
    parser = argparse.ArgumentParser(prog="python -m flightapp.fleet.election.model", description=__doc__.split("\n")[0])
    parser.add_argument("--nodes", type=int, choices=range(1, len(NAMES) + 1), default=3, help="members of the roster")
    parser.add_argument("--depth", type=int, default=8, help="longest schedule, in transitions")
    parser.add_argument("--crashes", type=int, default=1, help="how many crashes a schedule may have")
    parser.add_argument("--situations-max", type=int, default=3_000_000, help="of each set of clocks; about 1 kB each")
    options = parser.parse_args(arguments)
    total = Explored()
    for rates in drifting(options.nodes, TIMING.clock_drift_max):
        total.add(Model(rates).explore(options.depth, options.crashes, options.situations_max))
    print(  # noqa: T201
        f"{options.nodes} nodes, depth {total.depth}, {options.crashes} crash(es), {options.nodes + 1} sets of clocks: "
        f"{total.situations} situations, {total.transitions} transitions, {total.schedules} schedules, terms up to "
        f"{total.term_max}; no rule broken; {total.healed} healed, the slowest in {total.healing_max_s:g} beacon periods"
    )


if __name__ == "__main__":
    main()

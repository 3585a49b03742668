"""To whom a vehicle's state goes, and how often: at the full rate to those for whom it matters, slower to the others.

Each vehicle sends its state to each other one by itself (a mesh of unicast links: packets are the cost, not what is in them), so
ten vehicles at 20 Hz put 1800 packets a second on the air. A mate is *near*

- with whom this vehicle would have to brake now or soon: nearer than the separation to keep plus the way in which the two can
  brake the speed at which they may be closing (`Need.is_near`);
- who was never heard or is not heard any more: it may be anywhere.

The nearest `fast_count` mates, as many as the fleet's budget allows, get every state, and so do the nearest `NEAR_FAST_MIN` of
those that are near, who is heard before who is not; all other near ones every second, everybody else every fourth. In a team of
up to seven, five with certificates, everybody gets every state. A rate falls a while after the reason for it has gone, never
before.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from flightapp.fleet.messages.units import Triple

SLOW_EVERY = 4
"""5 Hz of 20 Hz."""
NEAR_EVERY = 2
NEAR_FAST_MIN = 2
"""Two gaps to keep at a time: beside, or before and behind."""
STATE_PACKET_BYTES = 95
"""A state and the headers below it, IP's included, as `tools/fleet_traffic.py` counts them."""
OTHER_BYTES_S = 640
"""All else that one vehicle tells one other a second: intent, sightings, discs, election, time."""
CLOSED_WEIGHT = 2.0
"""How much more a closed fleet sends: packets of QUIC are larger, and are acknowledged. 2.05 of ten vehicles, 1.83 of five."""
LEAVING_M = 1.0
"""How much farther away a mate must be than where its full rate began, before that ends."""
LEAVING_S = 1.0
"""And for how long."""
PLACE_KEPT = 0.8
"""Among the nearest a mate keeps its place until another one is at less than this share of its distance."""


@dataclass(frozen=True, slots=True)
class Mate:
    """Another vehicle as it was heard last, or the own: mission frame NED; `age_s` since that was true."""

    position_ned_m: Triple
    velocity_ned_m_s: Triple
    age_s: float


@dataclass(frozen=True, slots=True)
class Need:
    """When two vehicles matter to each other. stop_m(speed): the way in which a vehicle can brake a closing speed (m/s)."""

    keep_m: float
    """Between the two, at rest."""
    acceleration_max_m_s2: float
    widening_max_m: float
    """The separation guard keeps the age of a state times its speed on top, up to this."""
    stop_m: Callable[[float], float]
    silent_s: float
    """Whoever was heard so long ago is not heard any more."""

    def is_near(self, own: Mate, mate: Mate, slow_period_s: float, margin_m: float = 0.0) -> bool:
        """Whether the two are, or may be, so near and closing so fast that one of them has to brake.

        It errs on the near side only: what was heard is carried on by its velocity, and whatever either may have accelerated
        since counts as towards the other. Heights do not count.
        """
        north, east = (
            theirs + speed * mate.age_s - mine - own_speed * own.age_s
            for theirs, speed, mine, own_speed in zip(
                mate.position_ned_m[:2], mate.velocity_ned_m_s[:2], own.position_ned_m[:2], own.velocity_ned_m_s[:2], strict=True
            )
        )
        distance_m = math.hypot(north, east)
        v_north, v_east = (mate.velocity_ned_m_s[k] - own.velocity_ned_m_s[k] for k in (0, 1))
        gained_m_s = self.acceleration_max_m_s2 * (mate.age_s + own.age_s)
        gained_m = 0.5 * self.acceleration_max_m_s2 * (mate.age_s**2 + own.age_s**2)
        closing_m_s = gained_m_s + _closing_m_s((north, east), (v_north, v_east), gained_m)
        fastest_m_s = gained_m_s + max(math.hypot(*own.velocity_ned_m_s[:2]), math.hypot(*mate.velocity_ned_m_s[:2]))
        widening_m = min(self.widening_max_m, fastest_m_s * slow_period_s)
        return distance_m - gained_m - margin_m <= self.keep_m + widening_m + self.stop_m(max(0.0, closing_m_s))


def _closing_m_s(offset_m: tuple[float, float], velocity_m_s: tuple[float, float], unsure_m: float) -> float:
    """Greatest closing speed of somebody at `offset_m`, give or take `unsure_m`, who moves at `velocity_m_s` relative to here."""
    distance_m, speed_m_s = math.hypot(*offset_m), math.hypot(*velocity_m_s)
    if distance_m <= unsure_m or distance_m == 0.0:
        return speed_m_s
    straight_m_s = -(offset_m[0] * velocity_m_s[0] + offset_m[1] * velocity_m_s[1]) / distance_m
    off_course = math.acos(max(-1.0, min(1.0, straight_m_s / speed_m_s))) if speed_m_s > 0.0 else 0.0
    return speed_m_s * math.cos(max(0.0, off_course - math.asin(unsure_m / distance_m)))


def fast_count(vehicles: int, state_rate_hz: float, fleet_kbit_s: float, *, closed: bool = False) -> int:
    """How many mates a vehicle may tell its state at the full rate, so that the whole fleet sends at most `fleet_kbit_s`.

    closed: with certificates, over QUIC.
    """
    others = vehicles - 1
    kbit_s = STATE_PACKET_BYTES * 8e-3
    slow_hz = state_rate_hz / SLOW_EVERY
    share_kbit_s = fleet_kbit_s / (max(vehicles, 1) * (CLOSED_WEIGHT if closed else 1.0))
    left_kbit_s = share_kbit_s - others * (slow_hz * kbit_s + OTHER_BYTES_S * 8e-3)
    return max(0, min(others, math.floor(left_kbit_s / ((state_rate_hz - slow_hz) * kbit_s))))


def least_kbit_s(vehicles: int, state_rate_hz: float, *, closed: bool = False) -> float:
    """What the whole fleet sends while everybody tells everybody at the slow rate: a smaller budget cannot be kept."""
    states_kbit_s = state_rate_hz / SLOW_EVERY * STATE_PACKET_BYTES * 8e-3
    return vehicles * (vehicles - 1) * (states_kbit_s + OTHER_BYTES_S * 8e-3) * (CLOSED_WEIGHT if closed else 1.0)


@dataclass(frozen=True, slots=True)
class Rates:
    """Who is told at which rate now; whoever is in neither set at the slow one."""

    full: frozenset[str]
    half: frozenset[str]


class StateRates:
    """Asked once a state period; holds who is on the full rate and since when there is no more reason for it."""

    def __init__(self, state_rate_hz: float, count: int, need: Need) -> None:
        """count: how many are told at the full rate whether they are near or not."""
        self.period_s = 1.0 / state_rate_hz
        self.slow_period_s = SLOW_EVERY / state_rate_hz
        self._count, self._need = count, need
        self._near_until_s: dict[str, float] = {}
        self._full: set[str] = set()

    def at(self, now_s: float, own: Mate, mates: Mapping[str, Mate | None]) -> Rates:
        """From `now_s` on. mates: all others, None where one was never heard."""
        for name, mate in mates.items():
            if mate is None or mate.age_s > self._need.silent_s or self._is_near(now_s, name, own, mate):
                self._near_until_s[name] = now_s + LEAVING_S
        near = {name for name in mates if self._near_until_s.get(name, -math.inf) > now_s}
        ranked = sorted(
            mates,
            key=lambda name: (name not in near, not self._is_heard(mates[name]), self._rank_m(name, own, mates[name]), name),
        )
        self._full = set(ranked[: max(self._count, min(NEAR_FAST_MIN, len(near)))])
        return Rates(frozenset(self._full), frozenset(near - self._full))

    def _is_heard(self, mate: Mate | None) -> bool:
        return mate is not None and mate.age_s <= self._need.silent_s

    def _is_near(self, now_s: float, name: str, own: Mate, mate: Mate) -> bool:
        margin_m = LEAVING_M if self._near_until_s.get(name, -math.inf) > now_s else 0.0
        return self._need.is_near(own, mate, self.slow_period_s, margin_m)

    def _rank_m(self, name: str, own: Mate, mate: Mate | None) -> float:
        if mate is None:
            return math.inf
        distance_m = math.dist(own.position_ned_m[:2], mate.position_ned_m[:2])
        return distance_m * (PLACE_KEPT if name in self._full else 1.0)

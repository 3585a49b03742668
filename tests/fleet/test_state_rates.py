"""Whoever may have to brake for a mate gets its every state, whatever both do and however late they hear of each other."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.fleet.state_rates import LEAVING_S, NEAR_FAST_MIN, SLOW_EVERY, Mate, Need, Rates, StateRates, fast_count
from flightapp.safety.braking import Braking

RATE_HZ = 20.0
PERIOD_S = 1.0 / RATE_HZ
ACCELERATION_M_S2 = 5.0
BRAKING = Braking(4.0, 0.35)
KEEP_M = 2.2
NEED = Need(KEEP_M, ACCELERATION_M_S2, 5.0, BRAKING.stop_m, silent_s=1.0)
SPEED_MAX_M_S = 6.0

NOBODY: frozenset[str] = frozenset()


def mate(north_m: float, east_m: float = 0.0, v_north_m_s: float = 0.0, v_east_m_s: float = 0.0, age_s: float = 0.0) -> Mate:
    return Mate((north_m, east_m, -5.0), (v_north_m_s, v_east_m_s, 0.0), age_s)


class Body:
    """A point mass that accelerates as it is told, at most ACCELERATION_M_S2, and stays below its top speed."""

    def __init__(self, north_m: float, east_m: float, v_north_m_s: float, v_east_m_s: float) -> None:
        self.at, self.velocity = (north_m, east_m), (v_north_m_s, v_east_m_s)

    def towards(self, other: Body) -> float:
        return math.atan2(other.at[1] - self.at[1], other.at[0] - self.at[0])

    def step(self, bearing_rad: float) -> None:
        gained = ACCELERATION_M_S2 * PERIOD_S
        v = self.velocity[0] + gained * math.cos(bearing_rad), self.velocity[1] + gained * math.sin(bearing_rad)
        before, self.velocity = self.velocity, v if math.hypot(*v) <= SPEED_MAX_M_S else self.velocity
        mean = [(one + other) / 2.0 for one, other in zip(before, self.velocity, strict=True)]
        self.at = self.at[0] + mean[0] * PERIOD_S, self.at[1] + mean[1] * PERIOD_S


def must_brake(own: Body, other: Body) -> bool:
    """By the truth: one of them could not wait any more, were it to keep the separation."""
    north, east = other.at[0] - own.at[0], other.at[1] - own.at[1]
    distance_m = math.hypot(north, east)
    v_north, v_east = other.velocity[0] - own.velocity[0], other.velocity[1] - own.velocity[1]
    closing_m_s = -(north * v_north + east * v_east) / max(distance_m, 1e-9)
    return distance_m <= KEEP_M + BRAKING.stop_m(max(0.0, closing_m_s))


places = st.floats(-25.0, 25.0)
speeds = st.floats(-4.0, 4.0)
bodies = st.builds(Body, places, places, speeds, speeds)


@settings(max_examples=60, deadline=None)
@given(
    bodies,
    st.lists(bodies, min_size=6, max_size=9),
    st.lists(st.lists(st.floats(-0.6, 0.6), min_size=10, max_size=10), min_size=15, max_size=25),
    st.integers(0, 6),
    st.integers(0, 3),
)
def test_no_mate_for_which_one_must_brake_is_ever_on_the_slow_rate(
    own: Body, others: list[Body], bearings_rad: list[list[float]], late_periods: int, count: int
) -> None:
    """The mates, who all make for it, are heard at the slow rate, `late_periods` after it was true."""
    rates = StateRates(RATE_HZ, count, NEED)
    heard = {number: (0, other.at, other.velocity) for number, other in enumerate(others)}
    history = [dict(heard)]
    for step, turns in enumerate(bearings_rad):
        now_s = step * PERIOD_S
        history.append({number: (step, other.at, other.velocity) for number, other in enumerate(others)})
        if step % SLOW_EVERY == 0:
            heard = history[max(0, len(history) - 1 - late_periods)]
        mates = {str(k): mate(*at, *v, (step - said) * PERIOD_S) for k, (said, at, v) in heard.items()}
        told = rates.at(now_s, mate(*own.at, *own.velocity), mates)
        braking_for = {str(number) for number, other in enumerate(others) if must_brake(own, other)}
        assert braking_for <= told.full | told.half
        assert len(told.full) >= max(count, min(NEAR_FAST_MIN, len(braking_for)))
        assert not told.full & told.half
        own.step(own.towards(others[0]) + turns[9])
        for other, turn in zip(others, turns, strict=False):
            other.step(other.towards(own) + turn)


def test_far_mates_are_slow_and_a_team_that_flies_side_by_side_is_not_all_near() -> None:
    rates = StateRates(RATE_HZ, 0, NEED)
    row = {str(k): mate(0.0, 6.0 * k, 4.0, 0.0, 0.2) for k in range(1, 10)}
    assert rates.at(0.0, mate(0.0, 0.0, 4.0), row) == Rates(NOBODY, NOBODY), "all fly alongside, 6 m apart"
    closing = {"1": mate(16.0, 0.0, -4.0, 0.0, 0.2), "2": mate(30.0, 0.0, -4.0, 0.0, 0.2)}
    assert rates.at(1.0, mate(0.0, 0.0, 4.0), closing).full == {"1"}, "head-on at 8 m/s 16 m are near"


def test_in_a_crowd_the_two_nearest_get_every_state_and_the_others_every_second() -> None:
    crowd = {str(k): mate(0.0, 1.0 + 0.1 * k) for k in range(9)}
    told = StateRates(RATE_HZ, 0, NEED).at(0.0, mate(0.0), crowd)
    assert told == Rates(frozenset(("0", "1")), frozenset("2345678"))


def test_who_was_never_heard_or_is_silent_may_be_anywhere() -> None:
    rates = StateRates(RATE_HZ, 0, NEED)
    assert rates.at(0.0, mate(0.0), {"new": None, "silent": mate(90.0, age_s=1.5), "far": mate(90.0)}).full == {"new", "silent"}


def test_who_is_not_heard_takes_no_place_from_a_near_mate_that_is() -> None:
    """Two that fell silent beside this vehicle may be anywhere; two living ones close in."""
    rates = StateRates(RATE_HZ, 0, NEED)
    heard = {"p2": mate(4.0, v_north_m_s=-3.0), "p3": mate(-4.0, v_north_m_s=3.0)}
    silent = {"p4": mate(1.0, age_s=2.0), "p5": mate(0.0, 1.0, age_s=2.0), "p6": None}
    assert rates.at(0.0, mate(0.0), heard | silent) == Rates(frozenset(heard), frozenset(silent))
    assert rates.at(1.0, mate(0.0), silent).full == {"p4", "p5"}, "among themselves the one that was nearest"


def test_the_full_rate_ends_late_and_the_nearest_do_not_flicker() -> None:
    rates = StateRates(RATE_HZ, 1, NEED)
    distances_m = [2.0, 40.0, 40.0]
    times_s = [0.0, 0.5 * LEAVING_S, 1.5 * LEAVING_S]
    got = [rates.at(t, mate(0.0), {"a": mate(d), "b": mate(28.0)}).full for t, d in zip(times_s, distances_m, strict=True)]
    assert got == [{"a"}, {"a"}, {"b"}]
    for nearer_m, kept in ((25.0, {"b"}), (20.0, {"a"})):
        assert rates.at(9.0, mate(0.0), {"a": mate(nearer_m), "b": mate(28.0)}).full == kept


@pytest.mark.parametrize("vehicles", range(2, 8))
def test_up_to_seven_everybody_gets_every_state(vehicles: int) -> None:
    assert fast_count(vehicles, RATE_HZ, 1000.0) == vehicles - 1


def test_a_large_team_or_a_thin_radio_has_less_at_the_full_rate() -> None:
    counts = [fast_count(vehicles, RATE_HZ, 1000.0) for vehicles in range(7, 30)]
    assert counts[-1] == 0
    assert sorted(counts[1:], reverse=True) == counts[1:]
    assert fast_count(4, RATE_HZ, 100.0) == 0


def test_a_closed_fleet_has_room_for_five_at_the_full_rate() -> None:
    assert [fast_count(vehicles, RATE_HZ, 1000.0, closed=True) for vehicles in (2, 3, 4, 5)] == [1, 2, 3, 4]
    assert fast_count(6, RATE_HZ, 1000.0, closed=True) < 5

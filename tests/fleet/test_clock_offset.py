"""Clock offsets from round trips: the truth lies within the stated uncertainty, whatever the link does."""

from hypothesis import given
from hypothesis import strategies as st

from flightapp.fleet.clock_offset import DRIFT_MAX, WINDOW_S, ClockOffset, RoundTrip

delays = st.floats(0.0001, 0.5)


@st.composite
def links(draw: st.DrawFn) -> list[tuple[float, float, float]]:
    """(asked_s, there_s, back_s): questions a second or more apart; ways of any lengths, independent of each other."""
    asked_s, trips = 1000.0, []
    for _ in range(draw(st.integers(1, 40))):
        asked_s += draw(st.floats(1.0, 20.0))
        trips.append((asked_s, draw(delays), draw(delays)))
    return trips


@given(links(), st.floats(-100.0, 100.0), st.floats(-DRIFT_MAX, DRIFT_MAX))
def test_the_truth_lies_within_the_uncertainty_although_clocks_drift(
    trips: list[tuple[float, float, float]], ahead_s: float, drift: float
) -> None:
    clock = ClockOffset()

    def truth_s(t_s: float) -> float:
        return ahead_s + drift * (t_s - 1000.0)

    for asked_s, there_s, back_s in trips:
        remote_s = asked_s + there_s + truth_s(asked_s + there_s)
        answered_s = asked_s + there_s + back_s
        clock.note(RoundTrip(asked_s, remote_s, answered_s))
        offset = clock.offset(answered_s)
        assert offset is not None
        assert abs(offset.ahead_s - truth_s(answered_s)) <= offset.uncertainty_s + DRIFT_MAX * 1.0 + 1e-9
        assert offset.uncertainty_s <= (there_s + back_s) / 2.0 + 1e-9, "never worse than the newest answer alone"
    assert clock.steps == 0, "delays are not taken for a jump of the clock"


def test_one_quick_answer_among_slow_ones_decides() -> None:
    clock = ClockOffset()
    for k, there_s in enumerate((0.2, 0.15, 0.002, 0.3)):
        asked_s = 1000.0 + k
        clock.note(RoundTrip(asked_s, asked_s + there_s + 30.0, asked_s + there_s + 0.002))
    offset = clock.offset(1004.0)
    assert offset is not None
    assert abs(offset.ahead_s - 30.0) < 0.001
    assert offset.uncertainty_s < 0.003


def test_an_old_quick_answer_makes_way_for_newer_ones() -> None:
    clock = ClockOffset()
    clock.note(RoundTrip(1000.0, 1000.001, 1000.002))
    for k in range(1, 100):
        asked_s = 1000.0 + k
        clock.note(RoundTrip(asked_s, asked_s + 0.01 + DRIFT_MAX / 2.0 * k, asked_s + 0.02))
    offset = clock.offset(1100.0)
    assert offset is not None
    assert abs(offset.ahead_s - DRIFT_MAX / 2.0 * 100.0) <= offset.uncertainty_s
    assert offset.ahead_s > DRIFT_MAX / 2.0 * (100.0 - WINDOW_S) - 1e-3, "the first answer is forgotten"


def test_a_clock_that_was_set_is_followed_with_the_next_answer() -> None:
    clock = ClockOffset()
    for k in range(5):
        clock.note(RoundTrip(1000.0 + k, 1000.001 + k, 1000.002 + k))
    clock.note(RoundTrip(1005.0, 975.03, 1005.06))
    offset = clock.offset(1005.1)
    assert offset is not None
    assert abs(offset.ahead_s + 30.0) <= offset.uncertainty_s
    assert clock.steps == 1


def test_an_always_asymmetric_link_misleads_by_half_the_asymmetry_and_says_so() -> None:
    clock = ClockOffset()
    for k in range(10):
        asked_s = 1000.0 + k
        clock.note(RoundTrip(asked_s, asked_s + 0.1, asked_s + 0.11))
    offset = clock.offset(1010.0)
    assert offset is not None
    assert abs(offset.ahead_s - 0.045) < 1e-3
    assert offset.ahead_s <= offset.uncertainty_s

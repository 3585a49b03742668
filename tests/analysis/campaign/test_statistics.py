"""Intervals and p-values: the source's published ones, and what must hold for any."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightapp.analysis.campaign.statistics import two_proportion_p_value, wilson_interval

Counts = st.integers(1, 5000).flatmap(lambda runs: st.tuples(st.integers(0, runs), st.just(runs)))


@pytest.mark.parametrize(("successes", "low", "high"), [(32, 50.1, 75.9), (43, 73.8, 93.0)])
def test_the_published_intervals_of_50_runs(successes: int, low: float, high: float) -> None:
    assert [100 * end for end in wilson_interval(successes, 50)] == pytest.approx([low, high], abs=0.05)


def test_the_published_p_value() -> None:
    assert two_proportion_p_value(43, 50, 32, 50) == pytest.approx(0.011, abs=5e-4)


@given(Counts)
def test_the_interval_contains_the_share_and_stays_a_share(counts: tuple[int, int]) -> None:
    successes, runs = counts
    low, high = wilson_interval(successes, runs)
    assert 0.0 <= low <= successes / runs <= high <= 1.0
    assert low < high


@given(Counts)
def test_the_interval_of_failures_is_the_mirror_image(counts: tuple[int, int]) -> None:
    successes, runs = counts
    low, high = wilson_interval(successes, runs)
    assert wilson_interval(runs - successes, runs) == pytest.approx((1.0 - high, 1.0 - low), abs=1e-12)


@given(Counts, Counts)
def test_it_does_not_matter_which_planner_is_compared_with_which(one: tuple[int, int], other: tuple[int, int]) -> None:
    p_value = two_proportion_p_value(*one, *other)
    assert 0.0 <= p_value <= 1.0
    assert two_proportion_p_value(*other, *one) == pytest.approx(p_value, abs=1e-12)
    assert two_proportion_p_value(*one, *one) == pytest.approx(1.0)

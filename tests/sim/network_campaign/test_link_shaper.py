"""The shaper's links have the statistics that they were asked for, and the same ones each time."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.sim.link_shaper import LinkQuality, LinkShaper

qualities = st.builds(
    lambda delay_s, share, loss: LinkQuality(delay_s, delay_s * share, loss),
    st.floats(0.0, 0.5),
    st.floats(0.0, 1.0),
    st.floats(0.0, 0.9),
)
seeds = st.integers(0, 10_000)
PACKETS = 400


def passed(shaper: LinkShaper, count: int = PACKETS) -> list[float | None]:
    return [shaper.delay_s("p1", "p2") for _ in range(count)]


@settings(deadline=None)
@given(qualities, seeds)
def test_delays_stay_within_the_jitter(quality: LinkQuality, seed: int) -> None:
    arrived = [delay_s for delay_s in passed(LinkShaper(quality, seed)) if delay_s is not None]
    assert all(
        quality.delay_s - quality.jitter_s - 1e-9 <= delay_s <= quality.delay_s + quality.jitter_s + 1e-9 for delay_s in arrived
    )
    assert all(delay_s >= -1e-9 for delay_s in arrived)


@settings(deadline=None)
@given(seeds, st.floats(0.0, 0.9), st.floats(0.0, 0.9))
def test_more_loss_loses_the_same_packets_and_more(seed: int, one: float, other: float) -> None:
    less, more = sorted((one, other))
    few, many = (passed(LinkShaper(LinkQuality(0.1, 0.05, loss), seed)) for loss in (less, more))
    assert all(kept is None or kept == before for before, kept in zip(few, many, strict=True))


@settings(deadline=None)
@given(qualities, seeds)
def test_a_link_does_not_feel_what_others_send(quality: LinkQuality, seed: int) -> None:
    alone, busy = LinkShaper(quality, seed), LinkShaper(quality, seed)
    seen = []
    for _ in range(50):
        busy.delay_s("p2", "p1")
        busy.delay_s("p1", "p3")
        seen.append(busy.delay_s("p1", "p2"))
    assert seen == passed(alone, 50)


@pytest.mark.parametrize("loss", [0.0, 0.1, 0.3])
def test_share_of_lost_packets_and_mean_delay_are_as_asked(loss: float) -> None:
    count = 20_000
    arrived = [delay_s for delay_s in passed(LinkShaper(LinkQuality(0.1, 0.05, loss), 1), count) if delay_s is not None]
    assert 1.0 - len(arrived) / count == pytest.approx(loss, abs=0.015)
    assert sum(arrived) / len(arrived) == pytest.approx(0.1, abs=0.002)
    assert any(later < earlier for earlier, later in itertools.pairwise(arrived))


@settings(deadline=None)
@given(st.sets(st.sampled_from(["p1", "p2", "p3", "e1"])), seeds)
def test_a_partition_lets_nothing_across_and_everything_within_until_it_heals(side: set[str], seed: int) -> None:
    shaper = LinkShaper(LinkQuality(0.01), seed)
    shaper.split(side)
    for one, other in itertools.permutations(("p1", "p2", "p3", "e1"), 2):
        assert (shaper.delay_s(one, other) is None) == ((one in side) != (other in side))
    shaper.heal()
    assert all(shaper.delay_s(one, other) is not None for one, other in itertools.permutations(("p1", "p2", "p3", "e1"), 2))


@pytest.mark.parametrize(
    ("quality", "told"), [((0.01, 0.02, 0.0), "jitter"), ((0.01, 0.0, 1.0), "loss"), ((0.01, 0.0, -0.1), "loss")]
)
def test_a_link_that_cannot_be_is_refused(quality: tuple[float, float, float], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        LinkQuality(*quality)

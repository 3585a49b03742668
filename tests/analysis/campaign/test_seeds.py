"""Seeds as a person writes them."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightapp.analysis.campaign.seeds import parse_batch, parse_seeds, seeds_text
from flightapp.core.errors import InputError


@given(st.sets(st.integers(0, 300), min_size=1))
def test_seeds_survive_being_written(seeds: set[int]) -> None:
    rising = tuple(sorted(seeds))
    assert parse_seeds(seeds_text(rising)) == rising


@pytest.mark.parametrize("text", ["9-3", "", "a", "1-", "-1", "1,,2", "1.5", "0-99999999"])
def test_anything_else_is_refused_by_name(text: str) -> None:
    with pytest.raises(InputError, match=f"--seeds {text}"):
        parse_seeds(text)


def test_a_batch_is_taken_from_the_front() -> None:
    assert parse_batch("10000-", 3) == (10000, 10001, 10002)
    assert parse_batch("20000-20009", 2) == (20000, 20001)
    with pytest.raises(InputError, match="2 seeds for a batch of 3"):
        parse_batch("20000,20004", 3)

"""When a capture counts: by most of those that are assigned, each by its own view, announced by the leader."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from flightapp.fleet.coordination.agreement import VERDICT_AGE_MAX_S, Agreement, Capture, Verdict
from flightapp.fleet.coordination.core import Voice

ALL = ("p1", "p2", "p3")
SEEN_ALL = Verdict(frozenset(ALL))
LEADS = Voice("p1", 1, is_own=True)
FOLLOWS = Voice("p2", 1, is_own=False)
NOBODY = Voice(None, 2, is_own=False)


def test_the_leader_announces_what_it_and_most_of_the_assigned_have_seen() -> None:
    assert Agreement("p1").step(0.0, LEADS, ALL, SEEN_ALL, []) is None, "one of three is no majority"
    capture = Agreement("p1").step(0.0, LEADS, ALL, SEEN_ALL, [("p3", SEEN_ALL)])
    assert capture == Capture(ALL, ("p1", "p3"))


def test_who_does_not_lead_announces_nothing_while_somebody_does() -> None:
    assert Agreement("p1").step(0.0, FOLLOWS, ALL, SEEN_ALL, [("p2", SEEN_ALL), ("p3", SEEN_ALL)]) is None


def test_without_a_leader_a_majority_is_enough_and_less_is_not() -> None:
    assert Agreement("p1").step(0.0, NOBODY, ALL, SEEN_ALL, []) is None
    assert Agreement("p1").step(0.0, NOBODY, ALL, SEEN_ALL, [("p2", SEEN_ALL)]) == Capture(ALL, ("p1", "p2"))


def test_a_dead_teammate_that_was_forgotten_makes_nobody_captured_before_a_leader_plans_without_it() -> None:
    two = Verdict(frozenset(("p1", "p2")))
    for voice in (LEADS, NOBODY):
        agreement = Agreement("p1")
        assert agreement.step(0.0, voice, ALL, two, [("p2", two)]) is None
        assert agreement.step(0.1, voice, ("p1", "p2"), two, []) == Capture(("p1", "p2"), ("p1", "p2"))


def test_an_old_verdict_is_no_verdict() -> None:
    agreement = Agreement("p1")
    agreement.step(0.0, LEADS, ALL, None, [("p2", SEEN_ALL)])
    assert agreement.step(VERDICT_AGE_MAX_S + 0.1, LEADS, ALL, SEEN_ALL, []) is None


def test_a_leader_announces_what_most_have_seen_also_if_it_is_held_or_on_the_ground() -> None:
    others = [("p2", SEEN_ALL), ("p3", SEEN_ALL)]
    assert Agreement("p1").step(0.0, LEADS, ALL, None, others) == Capture(ALL, ("p2", "p3"))
    pair = Verdict(frozenset(("p2", "p3")))
    assert Agreement("p1").step(0.0, LEADS, ("p2", "p3"), None, [("p2", pair), ("p3", pair)]) is not None
    assert Agreement("p1").step(0.0, NOBODY, ALL, None, others) is None, "without a leader nobody speaks for others alone"


FIVE = ("p1", "p2", "p3", "p4", "p5")


@given(
    st.lists(st.sampled_from(FIVE), min_size=1, unique=True),
    st.dictionaries(st.sampled_from((*FIVE[1:], "stranger")), st.sets(st.sampled_from(FIVE))),
    st.booleans(),
)
def test_no_capture_without_more_than_half_of_the_assigned_having_seen_every_assigned(
    assigned: list[str], heard: dict[str, set[str]], leaderless: bool
) -> None:
    own = Verdict(frozenset(FIVE))
    inbox = [(name, Verdict(frozenset(by))) for name, by in heard.items()]
    capture = Agreement("p1").step(0.0, NOBODY if leaderless else LEADS, assigned, own, inbox)
    saw = {name for name, by in heard.items() if by >= set(assigned)} | {"p1"}
    most = 2 * len(saw & set(assigned)) > len(assigned)
    assert (capture is not None) == (most and ("p1" in assigned or not leaderless))

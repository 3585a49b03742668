"""Which messages are taken, whatever the network does to them."""

from dataclasses import dataclass
from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from flightapp.fleet.admission import FUTURE_TOLERANCE_S, Admission, Verdict
from flightapp.fleet.messages.codec import Header

AGE_MAX_S = 1.0


def test_repeated_reordered_late_and_future_ones_are_not_taken() -> None:
    admission = Admission(AGE_MAX_S)

    def judge(sequence: int, sent_s: float, now_s: float) -> Verdict:
        return admission.judge(Header("p1", sequence, sent_s), 0.0, now_s)

    assert judge(5, 100.0, 100.0) is Verdict.TAKEN
    assert judge(5, 100.0, 100.0) is Verdict.REPEATED
    assert judge(4, 99.9, 100.0) is Verdict.REORDERED
    assert judge(6, 101.0, 100.05) is Verdict.FUTURE
    assert judge(6, 98.9, 100.05) is Verdict.LATE
    assert judge(9, 100.2, 100.2) is Verdict.TAKEN
    assert (admission.lost, admission.rejected) == (3, 4)


def test_a_restarted_vehicle_counts_from_one_again_and_is_heard() -> None:
    admission = Admission(AGE_MAX_S)
    assert admission.judge(Header("p1", 500, 100.0), 0.0, 100.0) is Verdict.TAKEN
    assert admission.judge(Header("p1", 1, 100.3), 0.0, 100.4) is Verdict.TAKEN
    assert admission.lost == 0


def test_a_restarted_vehicle_whose_clock_was_set_back_is_heard_after_a_silence() -> None:
    admission = Admission(AGE_MAX_S)
    assert admission.judge(Header("p1", 500, 100.0), 0.0, 100.0) is Verdict.TAKEN
    behind_s = -30.0
    after_s = 102.0
    assert admission.judge(Header("p1", 1, after_s), behind_s, after_s) is Verdict.TAKEN


@dataclass(frozen=True)
class Sent:
    """One message and what the network does to it: it arrives at each of `arrivals_s`, maybe never."""

    header: Header
    arrivals_s: tuple[float, ...]


@st.composite
def flights(draw: st.DrawFn) -> list[Sent]:
    """Messages 50 ms apart: lost, repeated, delayed up to 3 s, so that they overtake each other; some stamped wrongly."""
    count = draw(st.integers(1, 30))
    sent = []
    for sequence in range(count):
        t_s = 1000.0 + sequence * 0.05
        delays_s = draw(st.lists(st.floats(0.0, 3.0), max_size=3))
        wrong_s = draw(st.sampled_from([0.0, 0.0, 0.0, 0.5, 40.0, -40.0]))
        sent.append(Sent(Header("p1", sequence, t_s + wrong_s), tuple(t_s + delay_s for delay_s in delays_s)))
    return sent


@given(flights(), st.floats(-100.0, 100.0))
def test_what_is_taken_is_fresh_never_from_the_future_and_never_goes_back(sent: list[Sent], clock_ahead_s: float) -> None:
    admission = Admission(AGE_MAX_S)
    arrivals = sorted(((at_s, one.header) for one in sent for at_s in one.arrivals_s), key=lambda pair: pair[0])
    taken: list[Header] = []
    for at_s, header in arrivals:
        if admission.judge(header, clock_ahead_s, at_s) is Verdict.TAKEN:
            assert -FUTURE_TOLERANCE_S <= at_s - header.sent_s <= AGE_MAX_S
            taken.append(header)
    stamps_s = [header.sent_s for header in taken]
    assert all(later > earlier for earlier, later in pairwise(stamps_s)), "time never goes back"
    assert len({header.sequence for header in taken}) == len(taken), "nothing is taken twice"
    assert sum(admission.counts.values()) == len(arrivals), "everything that arrived is counted"


@given(st.lists(st.floats(0.0, 0.04), min_size=1, max_size=30), st.floats(-100.0, 100.0))
def test_on_a_good_link_everything_is_taken(delays_s: list[float], clock_ahead_s: float) -> None:
    admission = Admission(AGE_MAX_S)
    for sequence, delay_s in enumerate(delays_s):
        sent_s = 1000.0 + sequence * 0.05
        assert admission.judge(Header("p1", sequence, sent_s), clock_ahead_s, sent_s + delay_s) is Verdict.TAKEN
    assert admission.lost == 0

"""Who is obeyed: the leader that is followed, its newest plan, and nobody else; and what is done when one comes or goes."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from flightapp.fleet.coordination.core import JOIN_S, Coordinator, Voice
from flightapp.fleet.coordination.plan import Plan, Seat
from flightapp.fleet.coordination.scene import Pursuer, Scene
from flightapp.fleet.coordination.sector_plan import PLAN_PERIOD_S, SectorPlan
from flightapp.fleet.messages.codec import Header, decode, encode
from flightapp.fleet.messages.plan import PLAN
from tests.fleet.coordination.test_sectors import OPEN, RING_M

NAMES = ("p1", "p2", "p3")
FOLLOWS = Voice("p1", 1, is_own=False)
LEADS = Voice("p1", 1, is_own=True)
NOBODY = Voice(None, 2, is_own=False)


def scene_of(*names: str) -> Scene:
    pursuers = tuple(Pursuer(name, -20.0, 5.0 * NAMES.index(name), 5.0) for name in names)
    return Scene(0.0, 0.0, 0.0, 0.0, pursuers, OPEN)


def plan_of(term: int, version: int, *names: str) -> Plan:
    return Plan(term, version, tuple(Seat(name, 0.1 * k, 0.0, 0.0, 9.0) for k, name in enumerate(names)))


heard = st.tuples(
    st.sampled_from(NAMES), st.builds(lambda term, version: plan_of(term, version, *NAMES), st.integers(0, 4), st.integers(1, 6))
)
voices = st.builds(Voice, st.sampled_from((None, *NAMES)), st.integers(0, 4), is_own=st.just(False))


@given(st.lists(st.tuples(voices, st.lists(heard, max_size=4)), max_size=30))
def test_whatever_is_heard_the_plan_in_force_never_goes_back_and_is_the_leaders(
    story: list[tuple[Voice, list[tuple[str, Plan]]]],
) -> None:
    core = Coordinator(SectorPlan(RING_M))
    before = None
    for number, (voice, inbox) in enumerate(story):
        core.step(0.04 * number, voice, None, inbox)
        if core.plan is not before:
            assert core.plan is not None
            assert before is None or core.plan.rank > before.rank
            assert core.plan.term == voice.term
            assert (voice.leader, core.plan) in [(sender, plan) for sender, plan in inbox]
        before = core.plan


def test_without_a_leader_the_last_plan_stays_whatever_is_heard() -> None:
    core = Coordinator(SectorPlan(RING_M))
    core.step(0.0, FOLLOWS, scene_of(*NAMES), [("p1", plan_of(1, 3, *NAMES))])
    before = core.plan
    for tick in range(1, 200):
        assert core.step(0.1 * tick, NOBODY, scene_of("p2", "p3"), [("p3", plan_of(2, tick, "p3"))]) == []
    assert core.plan is before
    assert before is not None


def test_a_leader_plans_five_times_a_second_and_counts_on() -> None:
    core = Coordinator(SectorPlan(RING_M))
    sent = [plan for tick in range(100) for plan in core.step(0.04 * tick, LEADS, scene_of(*NAMES), ())]
    assert len(sent) == round(100 * 0.04 / PLAN_PERIOD_S)
    assert [plan.version for plan in sent] == list(range(1, len(sent) + 1))


def test_who_drops_out_is_planned_without_at_once_and_who_comes_back_has_to_stay_first() -> None:
    core = Coordinator(SectorPlan(RING_M))
    members = []
    for tick in range(50):
        there = NAMES if tick < 10 or tick >= 20 else ("p1", "p3")
        core.step(PLAN_PERIOD_S * tick, LEADS, scene_of(*there), ())
        assert core.plan is not None
        members.append(core.plan.members)
    assert members[9] == NAMES
    assert members[10] == ("p1", "p3")
    back = members.index(NAMES, 10)
    assert abs(PLAN_PERIOD_S * (back - 20) - JOIN_S) < PLAN_PERIOD_S


def test_a_new_leader_goes_on_with_the_seats_of_the_old_one() -> None:
    old, new = Coordinator(SectorPlan(RING_M)), Coordinator(SectorPlan(RING_M))
    (plan,) = old.step(0.0, LEADS, scene_of(*NAMES), ())
    new.step(0.0, FOLLOWS, scene_of(*NAMES), [("p1", plan)])
    (next_plan,) = new.step(1.0, Voice("p2", 2, is_own=True), scene_of(*NAMES), ())
    assert next_plan.rank == (2, 1)
    for seat, was in zip(next_plan.seats, plan.seats, strict=True):
        assert abs(seat.bearing_rad - was.bearing_rad) < 0.2


def test_the_plans_arrival_is_that_of_the_last_one() -> None:
    core = Coordinator(SectorPlan(RING_M))
    far = Pursuer("p2", -50.0, 0.0, 5.0)
    core.step(100.0, LEADS, Scene(0.0, 0.0, 0.0, 0.0, (Pursuer("p1", 5.0, 0.0, 5.0), far), OPEN), ())
    assert core.plan is not None
    seat = core.plan.seat_of("p2")
    assert seat is not None
    assert core.plan.arrival_s == seat.alone_s
    assert 100.0 + (50.0 - RING_M) / 5.0 - 0.1 < core.plan.arrival_s < 100.0 + (50.0 + RING_M) / 5.0


def test_a_chase_that_never_ends_is_still_a_plan_that_can_be_sent() -> None:
    core = Coordinator(SectorPlan(RING_M))
    (plan,) = core.step(0.0, LEADS, Scene(0.0, 0.0, 4.9999, 0.0, (Pursuer("p1", -50.0, 0.0, 5.0),), OPEN), ())
    header = Header("p1", 1, 0.0)
    heard, _ = decode(PLAN, encode(PLAN, plan, header))
    assert heard.rank == plan.rank

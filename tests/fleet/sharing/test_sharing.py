"""What is told of obstacles is sure, standing, no vehicle and of use; what was heard adds only what nobody here knows better."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.types import ObstacleSet
from flightapp.fleet.messages.discs import DISCS_MAX, Disc, Discs
from flightapp.fleet.sharing.choosing import BESIDE_WAY_M, TOLD_MAX, Presence, Seen, Way, worth_telling
from flightapp.fleet.sharing.heard import COVERED_M, MEMORY_S, REFUTED_S, TAKEN_MAX, HeardDiscs

few = settings(max_examples=30, deadline=None, database=None)
places = st.floats(-30.0, 30.0)
pairs = st.tuples(places, places)
rows = st.tuples(places, places, st.floats(0.05, 4.0), st.sampled_from((0.0, 0.1, 1.0)), st.just(0.0))
tolds = st.builds(Disc, places, places, st.floats(0.05, 4.0), st.sampled_from((0.0, 1.0)), st.just(0.0))
NOWHERE = (500.0, 500.0)
NONE = np.zeros((0, 3))
MATES_WAY = Way((0.0, 0.0), (20.0, 0.0))


def seen(*discs: tuple[float, ...], age_s: float = 0.0, confidence: float = 1.0) -> Seen:
    table = np.zeros((len(discs), 7))
    for place, row in enumerate(discs):
        table[place, : len(row)] = row
    return Seen(table, np.full(len(discs), age_s), np.full(len(discs), confidence))


@few
@given(
    discs=st.lists(rows, max_size=20),
    sure=st.randoms(use_true_random=False),
    vehicles=st.lists(st.builds(Presence, places, places, st.just(0.8), st.just(0.8), st.floats(0.0, 5.0)), max_size=3),
    ways=st.lists(st.builds(Way, pairs, pairs), max_size=3),
)
def test_what_is_told_is_sure_standing_no_vehicle_and_on_somebodys_way(discs, sure, vehicles, ways) -> None:  # type: ignore[no-untyped-def]
    given_all = seen(*discs)
    mixed = replace(
        given_all,
        age_s=np.array([sure.choice((0.0, 2.0)) for _ in discs]),
        confidence=np.array([sure.choice((0.5, 1.0)) for _ in discs]),
    )
    told = worth_telling(mixed, vehicles, ways)
    assert len(told) <= TOLD_MAX
    for disc in told:
        [*found] = [k for k, row in enumerate(discs) if row[:3] == (disc.north_m, disc.east_m, disc.radius_m)]
        assert any(mixed.age_s[k] == 0.0 and mixed.confidence[k] == 1.0 and discs[k][3] < 0.3 for k in found)
        assert disc.v_north_m_s == disc.v_east_m_s == 0.0
        place = np.array([[disc.north_m, disc.east_m, disc.radius_m]])
        assert min(way.beside_m(place)[0] for way in ways) <= BESIDE_WAY_M
        for vehicle in vehicles:
            away_m = math.hypot(disc.north_m - vehicle.north_m, disc.east_m - vehicle.east_m)
            assert away_m > disc.radius_m + vehicle.touching_m
            assert disc.radius_m > vehicle.size_m or away_m > disc.radius_m + vehicle.possible_m


def test_a_tree_on_a_mates_way_is_told_one_beside_the_own_way_only_is_not() -> None:
    both = seen((12.0, 1.0, 0.4), (-15.0, 0.0, 0.4))
    assert [disc.north_m for disc in worth_telling(both, (), (MATES_WAY,))] == [12.0]
    assert worth_telling(both, (), ()) == ()


def test_of_many_those_are_told_that_the_mate_does_not_see_itself_and_meets_first() -> None:
    row = seen(*((2.0 + 1.5 * k, 1.0, 0.3) for k in range(12)))
    told = worth_telling(row, (), (MATES_WAY,))
    assert [disc.north_m for disc in told] == [2.0 + 1.5 * k for k in range(3, 11)]


def test_a_target_that_may_be_anywhere_keeps_everything_of_its_size_back() -> None:
    lost = Presence(0.0, 0.0, 0.0, 0.75, math.inf)
    told = worth_telling(seen((12.0, 0.0, 0.4), (15.0, 0.0, 1.2)), (lost,), (MATES_WAY,))
    assert [disc.radius_m for disc in told] == [1.2]


@few
@given(
    messages=st.lists(
        st.tuples(st.sampled_from(("p2", "p3")), st.floats(-8.0, 2.0), st.lists(tolds, max_size=DISCS_MAX)), max_size=12
    ),
    own=st.lists(rows, max_size=6),
    own_m=pairs,
    vehicles=st.lists(st.builds(Presence, places, places, st.just(0.8), st.just(0.8), st.just(0.0)), max_size=2),
    free_north_m=places,
)
def test_what_was_heard_adds_a_few_recent_discs_where_nobody_here_knows_better(  # type: ignore[no-untyped-def]
    messages, own, own_m, vehicles, free_north_m
) -> None:
    heard, known = HeardDiscs(), seen(*own).discs
    for sender, t_s, discs in messages:
        heard.take(sender, Discs(t_s, tuple(discs)), 0.0)
    heard.look(0.0, own_m, 0.35, lambda north_m, _: north_m > free_north_m)
    added = heard.unknown(0.0, own_m, known, vehicles)
    assert len(added) <= TAKEN_MAX
    recent = {
        (disc.north_m, disc.east_m, disc.radius_m)
        for _, t_s, discs in messages
        for disc in discs
        if t_s >= -MEMORY_S and disc.v_north_m_s == 0.0
    }
    for north_m, east_m, radius_m in added.tolist():
        assert (north_m, east_m, radius_m) in recent
        assert radius_m <= 2.0
        assert north_m <= free_north_m
        assert math.hypot(north_m - own_m[0], east_m - own_m[1]) > radius_m + 0.35
        for row in own:
            assert math.hypot(north_m - row[0], east_m - row[1]) > max(radius_m, row[2]) + COVERED_M
        for vehicle in vehicles:
            assert math.hypot(north_m - vehicle.north_m, east_m - vehicle.east_m) > radius_m + vehicle.touching_m
    assert heard.unknown(MEMORY_S + 0.1, own_m, known, vehicles).size == 0
    everything = ObstacleSet(0.0, known, np.zeros((0, 2))).with_standing(added)
    np.testing.assert_array_equal(everything.discs[: len(known)], known)


def tell(heard: HeardDiscs, t_s: float, *discs: tuple[float, float, float], sender: str = "p2") -> None:
    heard.take(sender, Discs(t_s, tuple(Disc(*row, 0.0, 0.0) for row in discs)), t_s)


def test_a_disc_is_kept_for_a_few_seconds_after_it_was_last_told() -> None:
    heard = HeardDiscs()
    tell(heard, 0.0, (10.0, 0.0, 0.4))
    tell(heard, 3.0, (10.1, 0.0, 0.4))
    assert heard.unknown(3.0 + MEMORY_S, NOWHERE, NONE, ()).tolist() == [[10.1, 0.0, 0.4]]
    assert heard.unknown(3.1 + MEMORY_S, NOWHERE, NONE, ()).size == 0


def test_who_stamps_into_the_future_is_not_believed_for_longer() -> None:
    heard = HeardDiscs()
    heard.take("p2", Discs(1e6, (Disc(10.0, 0.0, 0.4, 0.0, 0.0),)), 0.0)
    assert heard.unknown(MEMORY_S + 0.1, NOWHERE, NONE, ()).size == 0


def test_a_place_seen_free_is_not_believed_occupied_while_somebody_repeats_it() -> None:
    heard = HeardDiscs()
    tell(heard, 0.0, (10.0, 0.0, 0.4), (10.0, 5.0, 0.4))
    heard.look(0.0, (0.0, 0.0), 0.35, lambda _, east_m: east_m < 1.0)
    for second in range(1, 6):
        tell(heard, float(second), (10.1, 0.0, 0.4), (10.0, 5.0, 0.4))
        heard.look(float(second), (0.0, 0.0), 0.35, None)  # The camera looks elsewhere.
        assert heard.unknown(float(second), NOWHERE, NONE, ()).tolist() == [[10.0, 5.0, 0.4]]
    tell(heard, REFUTED_S + 0.1, (10.1, 0.0, 0.4))
    assert [10.1, 0.0, 0.4] in heard.unknown(REFUTED_S + 0.1, NOWHERE, NONE, ()).tolist()


def test_the_parts_of_a_hut_stay_together_and_two_senders_of_one_tree_count_once() -> None:
    heard = HeardDiscs()
    hut = [(10.0, 0.6 * k, 0.6) for k in range(4)]
    tell(heard, 0.0, *hut)
    assert len(heard.unknown(0.0, NOWHERE, NONE, ())) == len(hut)
    tell(heard, 0.0, (10.2, 0.1, 0.6), sender="p3")
    assert len(heard.unknown(0.0, NOWHERE, NONE, ())) == len(hut)


def test_a_row_of_lies_is_bounded() -> None:
    heard = HeardDiscs()
    for second in range(60):
        tell(heard, float(second) * 0.05, *((3.0 * k, 5.0 * second, 0.5) for k in range(DISCS_MAX)))
    assert len(heard.unknown(3.0, (0.0, 0.0), NONE, ())) == TAKEN_MAX

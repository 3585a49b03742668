"""What a person who watches is told: checked on fleets that are only imagined."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightapp.config.mission import ProtectedBoundary
from flightapp.config.profile import load_profile
from flightapp.fleet.clock_offset import Offset
from flightapp.fleet.election.beacon import Beacon, Role
from flightapp.fleet.messages.sighting import Sighting
from flightapp.watch.data_model_alarms import Level
from flightapp.watch.data_model_confirmation import CONFIRM_WITHIN_S, Confirmation, Order
from flightapp.watch.data_model_fleet import FleetModel, Overview
from flightapp.watch.data_model_heard import Heard
from flightapp.watch.data_model_leader import leadership_of
from flightapp.watch.data_model_rows import Link
from flightapp.watch.data_model_target import boundary_distance_m, boundary_time_s
from flightapp.watch.data_model_thresholds import Thresholds, thresholds_of
from flightapp.watch.frontend_cells import HEADINGS, cells_of, leader_text, target_text
from flightapp.watch.frontend_machines import as_json_line, as_text
from tests.watch.scenes import DIGEST, MISSION, MISSION_FILE, NOW_S, ROLES, everybody, heard, state

LIMITS = Thresholds()


def look(*scenes: Heard) -> Overview:
    model = FleetModel(MISSION, DIGEST, LIMITS)
    return [model.look(scene) for scene in scenes][-1]


def alarms(*scenes: Heard) -> list[str]:
    return [alarm.text for alarm in look(*scenes).alarms]


def test_a_fleet_that_is_well_raises_no_alarm() -> None:
    assert alarms(heard(*everybody())) == []


def test_no_vehicle_at_all_is_one_alarm_that_says_so() -> None:
    overview = look(heard())
    assert not overview.is_heard
    assert [alarm.text for alarm in overview.alarms] == [
        "no vehicle is heard: is it on, and its endpoint among those connected to?"
    ]
    assert [row.link for row in overview.rows] == [Link.NEVER] * 3


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"sent_s": NOW_S - 3.2}, "p1 silent for 3 s, last pursue"),
        ({"t_s": NOW_S - 2.0}, "p1 has no own position for 2.0 s"),
        ({"phase": "land"}, "p1 lands before the pursuit has ended"),
        ({"phase": "return"}, "p1 returns before the pursuit has ended"),
        ({"phase": "released"}, "p1 is no longer flown by this software"),
        ({"outcome": "fault", "phase": "land"}, "p1: fault, now in phase land"),
        ({"clearance_m": 0.31}, "p1 is 0.3 m from an obstacle"),
        ({"mission": "another file"}, "p1 flies another version of the mission file"),
        ({"link_age_s": 4.0}, "p1 has not heard one of the others for 4.0 s"),
    ],
)
def test_every_trouble_of_a_vehicle_is_an_alarm_of_its_own(changes: dict[str, Any], words: str) -> None:
    (text,) = alarms(heard(state("p1", **changes), state("p2"), state("e1")))
    assert text.startswith(words)


def test_a_captured_fleet_that_goes_home_is_no_alarm_and_neither_is_one_whose_processes_have_ended() -> None:
    assert alarms(heard(*everybody(phase="return", outcome="captured"))) == []
    over = look(heard(*everybody(NOW_S - 60.0, phase="done", outcome="captured")))
    assert over.alarms == ()
    assert {row.link for row in over.rows} == {Link.OVER}


def test_a_vehicle_not_heard_yet_is_named_beside_those_that_are() -> None:
    assert alarms(heard(state("p1"), state("p2"))) == ["e1 was not heard yet"]


def test_alarms_come_before_warnings() -> None:
    overview = look(heard(state("p1", mission="another file"), state("p2", NOW_S - 9.0)))
    levels = [alarm.level for alarm in overview.alarms]
    assert levels == sorted(levels, reverse=True)
    assert set(levels) == {Level.ALARM, Level.WARNING}


def test_a_guard_is_an_alarm_once_it_has_acted_long_and_a_short_pause_does_not_hide_it() -> None:
    model = FleetModel(MISSION, DIGEST, LIMITS)
    told = {}
    for step in range(60):
        now_s = NOW_S + step * 0.1
        guards = () if step % 5 == 4 else ("separation",)
        told[step] = [alarm.text for alarm in model.look(heard(*everybody(now_s, guards=guards), now_s=now_s)).alarms]
    assert not any(told[step] for step in range(30))
    assert "p1: guard separation has acted for 5 s" in told[50]
    later_s = NOW_S + 10.0
    assert model.look(heard(*everybody(later_s), now_s=later_s)).alarms == ()
    assert model.look(heard(*everybody(later_s, guards=("separation",)), now_s=later_s)).alarms == ()


def test_clocks_that_are_off_are_named_and_what_that_will_do_to_commands() -> None:
    offsets = {"p1": Offset(0.2, 0.001), "p2": Offset(-2.5, 0.001), "e1": Offset(7.0, 0.001)}
    refused, behind = alarms(heard(*everybody(), offsets=offsets))
    assert refused == "the clock of e1 is 7.0 s ahead of this machine's: it will refuse hold and resume"
    assert behind == "the clock of p2 is 2.5 s behind this machine's"


@given(age_s=st.floats(0.0, 1e4))
def test_the_older_a_message_the_worse_the_link_and_a_word_says_it(age_s: float) -> None:
    (row, *_) = look(heard(state("p1", NOW_S - age_s))).rows
    order = [Link.FRESH, Link.LATE, Link.LOST]
    limits = [LIMITS.late_age_s, LIMITS.lost_age_s]
    assert row.age_s is not None
    assert row.link is order[sum(row.age_s > limit for limit in limits)]
    text = cells_of(row, LIMITS)[HEADINGS.index("link s")].text
    assert row.link is Link.FRESH or text.endswith(row.link.value)


def test_thresholds_are_those_by_which_the_vehicles_judge_each_other() -> None:
    profile = load_profile(MISSION_FILE.parents[1] / "profiles/sim.toml")
    assert Thresholds().lost_age_s == thresholds_of(profile).lost_age_s == 0.7
    slow = profile.model_copy(update={"network": profile.network.model_copy(update={"state_rate_hz": 2.0})})
    assert thresholds_of(slow).lost_age_s == 2.25
    assert thresholds_of(profile).clearance_min_m == profile.limits.safety_margin_m


def test_who_says_that_it_sends_rarely_is_lost_later_as_for_its_mates() -> None:
    for due_s, links in ((0.0, [Link.FRESH, Link.LOST, Link.LOST]), (0.2, [Link.FRESH, Link.LATE, Link.LOST])):
        aged = [state("p1", NOW_S - age_s, due_s=due_s) for age_s in (0.3, 0.8, 1.0)]
        assert [look(heard(one)).rows[0].link for one in aged] == links
    slow_team = everybody(due_s=0.2, link_age_s=0.85)
    assert not any("has not heard" in text for text in alarms(heard(*slow_team)))
    assert any("has not heard" in text for text in alarms(heard(*everybody(link_age_s=0.85))))


def beacon(role: Role, term: int, backs: str | None = None, sent_s: float = NOW_S - 0.1) -> tuple[float, Beacon]:
    return sent_s, Beacon(1.0, term, role, () if backs is None else ((backs, 1.0),))


def test_the_leader_is_who_says_so_in_the_newest_term_and_is_still_heard() -> None:
    votes = {"p1": beacon(Role.LEADER, 3), "p2": beacon(Role.FOLLOWER, 3, "p1")}
    overview = look(heard(*everybody(), beacons=votes))
    assert leader_text(overview) == "p1* leads, term 3, backed by p2"
    assert [row.name for row in overview.rows if row.leads] == ["p1"]
    dead = heard(*everybody(), beacons={"p1": beacon(Role.LEADER, 3, sent_s=NOW_S - 2.0), "p2": beacon(Role.SEEKING, 3)})
    assert leader_text(look(dead)) == "nobody leads, term 3"
    assert "nobody leads (term 3): the pursuers keep what was decided last" in alarms(dead)
    cut = heard(*everybody(), beacons={"p1": beacon(Role.LEADER, 3), "p2": beacon(Role.LEADER, 4)})
    assert leadership_of(cut).leader == "p2"
    assert alarms(cut) == ["several say that they lead: p2, p1"]
    assert leader_text(look(heard(*everybody()))) == "no election heard"


def test_the_target_is_told_by_its_telemetry_and_by_cameras_once_that_has_ended() -> None:
    evader = state("e1", position_ned_m=(30.0, 2.0, -5.0), velocity_ned_m_s=(-2.0, 0.0, 0.0))
    seen = Sighting(NOW_S - 0.2, 28.0, 3.0, 0.0, 0.3, 0.1)
    target = look(heard(evader, sightings={"p1": seen})).target
    assert target is not None
    assert (target.source, target.boundary_distance_m, target.boundary_time_s) == ("telemetry", 30.0, 15.0)
    silent = state("e1", NOW_S - 5.0, position_ned_m=(40.0, 2.0, -5.0))
    overview = look(heard(silent, sightings={"p1": seen}))
    assert overview.target is not None
    assert (overview.target.source, overview.target.boundary_distance_m) == ("p1", 28.0)
    assert target_text(overview) == "target e1: N 28 E 3 m, boundary 28.0 m (seen by p1, 0.2 s ago)"
    older = look(heard(silent, sightings={"p1": Sighting(NOW_S - 9.0, 28.0, 3.0, 0.0, 0.3, 0.1)})).target
    assert older is not None
    assert (older.source, older.age_s) == ("telemetry", 5.0)
    assert look(heard(state("p1"))).target is None


@given(
    st.tuples(st.floats(1.0, 60.0), st.floats(-29.0, 29.0)),
    st.tuples(st.floats(-10.0, 10.0), st.floats(-10.0, 10.0)),
)
def test_the_time_to_the_boundary_is_when_the_straight_course_gets_there(
    place: tuple[float, float], velocity: tuple[float, float]
) -> None:
    time_s = boundary_time_s(MISSION, place, velocity)
    if time_s is None:
        return
    assert place[0] + velocity[0] * time_s == pytest.approx(0.0, abs=1e-6)
    assert abs(place[1] + velocity[1] * time_s) <= 30.0 + 1e-6
    assert time_s * (velocity[0] ** 2 + velocity[1] ** 2) ** 0.5 >= boundary_distance_m(MISSION, place) - 1e-6


def test_a_target_that_stands_or_flies_away_never_crosses_and_one_inside_a_closed_boundary_has_no_way_left() -> None:
    assert boundary_time_s(MISSION, (30.0, 0.0), (0.0, 0.0)) is None
    assert boundary_time_s(MISSION, (30.0, 0.0), (2.0, 0.0)) is None
    assert boundary_time_s(MISSION, (30.0, 0.0), (-0.5, 3.0)) is None, "it leaves beside the end of the line"
    closed = ProtectedBoundary(vertices_m=((-5.0, -5.0), (5.0, -5.0), (5.0, 5.0), (-5.0, 5.0)), closed=True)
    inside = MISSION.model_copy(update={"boundary": closed})
    assert boundary_distance_m(inside, (0.0, 0.0)) == 0.0
    assert boundary_time_s(inside, (10.0, 0.0), (-2.5, 0.0)) == pytest.approx(2.0)


def test_what_changes_is_told_once() -> None:
    first = heard(*everybody(), beacons={"p1": beacon(Role.LEADER, 1)})
    lost_s = NOW_S + 3.0
    second = heard(state("p1"), *everybody(lost_s, guards=("separation",), phase="return")[1:], now_s=lost_s)
    back_s = NOW_S + 4.0
    third = heard(*everybody(back_s, guards=("separation",), phase="return"), now_s=back_s, complaints=("p2: cannot be read",))
    texts = [event.text for event in look(first, first, second, second, third).events]
    assert texts[:4] == [f"{name} is heard, in phase pursue" for name in ROLES] + ["p1 leads in term 1"]
    assert texts.count("p1 is silent") == texts.count("p1 is heard again") == texts.count("p1 leads no longer") == 1
    assert {"p2: pursue -> return", "p2: guard separation acts", "p2: cannot be read"} <= set(texts)
    assert texts.index("p1 is silent") < texts.index("p1 is heard again")


def test_json_and_plain_text_carry_what_the_terminal_shows() -> None:
    scene = heard(state("p1", NOW_S - 3.0), state("p2", guards=("separation",)), beacons={"p2": beacon(Role.LEADER, 2)})
    line = as_json_line(look(scene))
    assert "\n" not in line
    told = json.loads(line)
    lost, well, missing = told["vehicles"]
    assert (lost["link"], lost["age_s"], lost["leads"]) == ("LOST", 3.0, False)
    assert (well["link"], well["speed_m_s"], well["height_m"], well["guards"]) == ("fresh", 5.0, 5.0, {"separation": 0.0})
    assert (well["leads"], told["leader"], told["term"]) == (True, "p2", 2)
    assert (missing["link"], missing["age_s"], told["target"]) == ("not heard", None, None)
    assert told["alarms"][0] == {"level": "alarm", "vehicle": "p1", "text": "p1 silent for 3 s, last pursue"}
    text = as_text(look(scene), LIMITS)
    for words in ("3.0 LOST", "separation", "not heard", "p2*", "ALARM: p1 silent for 3 s"):
        assert words in text


ORDERS = [Order(action, vehicles) for action in ("hold", "land") for vehicles in (("p1",), ("p1", "p2"))]


@given(st.lists(st.tuples(st.sampled_from(ORDERS) | st.none(), st.floats(0.0, 5.0)), max_size=30))
def test_only_the_same_order_twice_in_time_and_with_nothing_between_is_ever_sent(
    presses: list[tuple[Order | None, float]],
) -> None:
    """None stands for escape. The reference: an order is sent where the last thing that was not used up is the same order."""
    confirmation, now_s = Confirmation(), 0.0
    open_order: tuple[Order, float] | None = None
    for order, pause_s in presses:
        now_s += pause_s
        if order is None:
            confirmation.cancel()
            open_order = None
            continue
        expected = open_order is not None and open_order[0] == order and now_s <= open_order[1] + CONFIRM_WITHIN_S
        assert confirmation.press(order, now_s) is expected
        open_order = None if expected else (order, now_s)
        assert confirmation.asked(now_s) == (None if expected else order)


@pytest.mark.parametrize(
    ("left", "shown", "level"),
    [(None, "-", None), (0.87, "87", None), (0.2, "20!", Level.WARNING), (0.08, "8!", Level.ALARM)],
)
def test_what_is_left_of_a_battery_is_shown_and_too_little_is_said(left: float | None, shown: str, level: Level | None) -> None:
    overview = look(heard(*everybody(battery_fraction=left)))
    assert cells_of(overview.rows[0], LIMITS)[HEADINGS.index("bat %")].text == shown
    said = {alarm.level for alarm in overview.alarms if "battery left" in alarm.text}
    assert said == ({level} if level else set())

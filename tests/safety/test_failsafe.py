"""The failsafe table and its machine: every state against every condition, alone and in pairs."""

from __future__ import annotations

import itertools
import json
import subprocess
import sys
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightapp.core.errors import InputError
from flightapp.safety.failsafe.explain import explain, parse_conditions, sentence
from flightapp.safety.failsafe.machine import RELEASE_S, Failsafe
from flightapp.safety.failsafe.table import TABLE, WISHES, By, Condition, Row, State, table_for

LONG_S = 1e4
KEPT = (State.RETURN, State.LAND, State.TERMINATE)
ENTRY = {
    State.NORMAL: (),
    State.DEGRADED: (Condition.TEAMMATE_SILENT,),
    State.HOLD: (Condition.OPERATOR_HOLD,),
    State.RETURN: (Condition.OPERATOR_RETURN,),
    State.LAND: (Condition.OPERATOR_LAND,),
    State.PILOT: (Condition.PILOT_HAS_CONTROL,),
}
"""How a machine gets into each state that the table reaches."""


def machine_in(state: State) -> Failsafe:
    machine = Failsafe()
    machine.step(0.0, ENTRY[state])
    assert machine.state is state
    return machine


def strictest(*conditions: Condition) -> State:
    """What the table asks for when `conditions` last for ever."""
    return max((row.action for row in TABLE if row.condition in conditions), default=State.NORMAL)


def test_every_condition_has_a_row_and_its_rows_escalate() -> None:
    for condition in Condition:
        rows = [row for row in TABLE if row.condition is condition]
        assert rows, condition
        for earlier, later in itertools.pairwise(rows):
            assert earlier.delay_s < later.delay_s
            assert earlier.action < later.action


def test_what_the_app_cannot_perform_itself_is_left_to_somebody_outside_it() -> None:
    by = {row.condition: row.by for row in TABLE}
    assert by[Condition.APP_DEAD] is By.AUTOPILOT
    assert by[Condition.LOOP_HUNG] is By.DEADMAN
    assert by[Condition.LINK_LOST] is By.AUTOPILOT


@pytest.mark.parametrize("state", ENTRY)
@pytest.mark.parametrize("condition", Condition)
def test_every_state_against_every_condition(state: State, condition: Condition) -> None:
    machine = machine_in(state)
    machine.step(1.0, (*ENTRY[state], condition))
    after = machine.step(1.0 + LONG_S, (*ENTRY[state], condition)).state
    asked = strictest(condition)
    if state is State.PILOT:
        assert after is (asked if condition in WISHES else State.PILOT)
    else:
        assert after is max(state, asked)


@pytest.mark.parametrize("state", ENTRY)
def test_of_two_conditions_the_stricter_wins_in_either_order(state: State) -> None:
    for one, other in itertools.permutations(Condition, 2):
        machine = machine_in(state)
        machine.step(1.0, (*ENTRY[state], one))
        machine.step(2.0, (*ENTRY[state], one, other))
        after = machine.step(LONG_S, (*ENTRY[state], one, other)).state
        if state is not State.PILOT and State.PILOT not in (strictest(one), strictest(other)):
            assert after is max(state, strictest(one, other)), (one, other)


@pytest.mark.parametrize("row", TABLE, ids=lambda row: f"{row.condition}-{row.action.name}")
def test_an_action_comes_with_its_delay_and_not_before(row: Row) -> None:
    machine = Failsafe()
    machine.step(0.0, (row.condition,))
    if row.delay_s > 0.0:
        assert machine.step(row.delay_s - 1e-6, (row.condition,)).state < row.action
    assert machine.step(row.delay_s, (row.condition,)).state is row.action


@pytest.mark.parametrize("state", [State.DEGRADED, State.HOLD])
def test_hold_and_degraded_end_a_moment_after_their_cause(state: State) -> None:
    machine = machine_in(state)
    assert machine.step(RELEASE_S - 0.01, ()).state is state
    verdict = machine.step(RELEASE_S, ())
    assert verdict.state is State.NORMAL
    assert verdict.is_new
    assert verdict.row is None


@pytest.mark.parametrize("state", [State.RETURN, State.LAND, State.PILOT])
def test_on_the_way_down_and_with_the_pilot_nothing_turns_round_by_itself(state: State) -> None:
    machine = machine_in(state)
    assert machine.step(LONG_S, ()).state is state


def test_a_flickering_cause_does_not_make_the_vehicle_flicker() -> None:
    machine = Failsafe()
    entered = 0
    for k in range(400):
        active = (Condition.FENCE_BREACHED,) if k % 7 < 3 else ()
        entered += machine.step(0.04 * k, active).is_new
    assert entered == 1


def test_between_persons_the_newest_word_counts() -> None:
    machine = Failsafe()
    pilot, wish = Condition.PILOT_HAS_CONTROL, Condition.OPERATOR_RETURN
    assert machine.step(0.0, (pilot,)).state is State.PILOT
    assert machine.step(1.0, (pilot, wish)).state is State.RETURN
    assert machine.step(1.1, (pilot, wish)).state is State.RETURN, "the takeover is older than the wish"
    assert machine.step(2.0, (wish,)).state is State.RETURN
    assert machine.step(3.0, (pilot, wish)).state is State.PILOT, "a new takeover is newer than the wish"
    assert machine.step(4.0, (pilot, wish)).state is State.PILOT


def test_a_wish_from_before_the_takeover_does_not_take_control_back() -> None:
    machine = Failsafe()
    machine.step(0.0, (Condition.OPERATOR_RETURN,))
    assert machine.step(1.0, (Condition.OPERATOR_RETURN, Condition.PILOT_HAS_CONTROL)).state is State.PILOT
    assert machine.step(LONG_S, (Condition.OPERATOR_RETURN, Condition.PILOT_HAS_CONTROL)).state is State.PILOT


def test_a_row_that_nobody_may_override_breaks_the_pilots_control() -> None:
    both = (Condition.PILOT_HAS_CONTROL, Condition.LOOP_FAILED)
    table = [replace(row, pilot_may_override=row.condition is not Condition.LOOP_FAILED) for row in TABLE]
    machine = Failsafe(table)
    machine.step(0.0, (Condition.PILOT_HAS_CONTROL,))
    assert machine.step(1.0, both).state is State.LAND
    assert machine.step(2.0, both).state is State.LAND


@pytest.mark.parametrize("action", [State.LAND, State.TERMINATE])
def test_a_pilot_outside_the_fence_is_neither_landed_nor_terminated(action: State) -> None:
    both = (Condition.PILOT_HAS_CONTROL, Condition.FENCE_OUTSIDE)
    machine = Failsafe(table_for(action))
    machine.step(0.0, (Condition.PILOT_HAS_CONTROL,))
    assert machine.step(LONG_S, both).state is State.PILOT
    alone = Failsafe(table_for(action))
    assert alone.step(0.0, (Condition.FENCE_OUTSIDE,)).state is action


def test_a_wish_that_is_asked_again_is_new() -> None:
    machine = Failsafe()
    wish, pilot = Condition.OPERATOR_RETURN, Condition.PILOT_HAS_CONTROL
    machine.step(0.0, (wish,))
    machine.step(1.0, (wish, pilot))
    machine.renew(wish)
    assert machine.step(2.0, (wish, pilot)).state is State.RETURN


@given(st.lists(st.tuples(st.floats(0.01, 5.0), st.frozensets(st.sampled_from(Condition), max_size=3)), max_size=40))
def test_whatever_happens_a_vehicle_never_goes_back_up(steps: list[tuple[float, frozenset[Condition]]]) -> None:
    machine = Failsafe()
    t_s, before = 0.0, State.NORMAL
    for dt_s, active in steps:
        t_s += dt_s
        verdict = machine.step(t_s, active)
        if before in KEPT:
            assert verdict.state >= before
        if before is State.PILOT and verdict.state is not State.PILOT:
            assert verdict.row is not None
            assert verdict.row.condition in WISHES
        assert (verdict.row is None) == (verdict.state is State.NORMAL)
        before = verdict.state


def test_explain_says_who_acts_and_why() -> None:
    text = sentence(explain(parse_conditions("link_lost=1, camera_lost=1"), 60.0))
    assert "LAND by the autopilot" in text
    assert "link_lost" in text
    assert "pilot may override" in text


def explained(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = (sys.executable, "-m", "flightapp", "explain", *arguments)
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)


def test_the_command_tells_a_person_which_action_wins_and_why() -> None:
    answer = explained("--set", "link_lost=1,camera_lost=1", "--after", "2")
    assert answer.returncode == 0
    assert "After 2 s: LAND by the autopilot, because of link_lost" in answer.stdout
    assert "no obstacle picture within" in answer.stdout


def test_the_command_tells_machines_the_same() -> None:
    answer = explained("--set", "camera_lost=1", "--after", "2", "--json")
    assert answer.returncode == 0
    told = json.loads(answer.stdout)
    assert told["state"] == "HOLD"
    assert told["because"]["condition"] == "camera_lost"
    assert [(row["action"], row["in_effect"]) for row in told["rows"]] == [("DEGRADED", True), ("HOLD", True), ("RETURN", False)]


def test_the_command_refuses_an_unknown_condition_in_one_sentence() -> None:
    answer = explained("--set", "linklost=1")
    assert answer.returncode == 2
    assert "'linklost': no such condition; known: " in answer.stderr
    assert "link_lost" in answer.stderr
    assert "Traceback" not in answer.stderr


@pytest.mark.parametrize(("text", "word"), [("linklost=1", "link_lost"), ("link_lost=maybe", "write 1 or 0")])
def test_explain_refuses_what_it_does_not_know(text: str, word: str) -> None:
    with pytest.raises(InputError, match=word):
        parse_conditions(text)

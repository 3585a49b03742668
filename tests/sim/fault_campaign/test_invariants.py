"""Every invariant finds the one thing that is wrong, and nothing where all is well."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from flightapp.sim.fault_campaign.flight import judge
from flightapp.sim.fault_campaign.invariants import INVARIANTS
from flightapp.sim.fault_campaign.trace import RecordingCheck, SentSetpoint, Takeover, Trace, Wish
from tests.sim.fault_campaign.traces import STEPS, calm_trace, felt


def violated(trace: Trace) -> list[tuple[str, str]]:
    """(invariant, vehicle)."""
    return [(one.invariant, one.vehicle) for one in judge(trace, Path("seed-0")).violations]


def resend(trace: Trace, vehicle: str, number: int, sent: SentSetpoint) -> None:
    trace.vehicles[vehicle].setpoints[number] = replace(sent, t_s=trace.vehicles[vehicle].setpoints[number].t_s)


def outside(trace: Trace) -> None:
    trace.vehicles["p1"].states[100, 1] = -20.5  # the polygon ends at -15 m, the contingency volume 5 m further


def too_high(trace: Trace) -> None:
    trace.vehicles["p1"].states[100, 3] = -23.5  # 18 m and 5 m


def too_fast(trace: Trace) -> None:
    resend(trace, "p1", 100, SentSetpoint(0.0, (4.0, 4.0, 0.0), 0.0, ("obstacle-stop",)))


def above_its_own_limit(trace: Trace) -> None:
    resend(trace, "e1", 100, SentSetpoint(0.0, (2.7, 0.0, 0.0), 0.0, ("obstacle-stop",)))


def climbing_too_fast(trace: Trace) -> None:
    resend(trace, "p1", 100, SentSetpoint(0.0, (0.1, 0.0, -2.2), 0.0, ()))


def changing_too_fast(trace: Trace) -> None:
    resend(trace, "p1", 100, SentSetpoint(0.0, (0.5, 0.0, 0.0), 0.0, ()))


def turning_too_fast(trace: Trace) -> None:
    resend(trace, "p1", 100, SentSetpoint(0.0, (0.1, 0.0, 0.0), 0.2, ()))


def not_finite(trace: Trace) -> None:
    resend(trace, "p1", 100, SentSetpoint(0.0, (float("nan"), 0.0, 0.0), 0.0, ()))


def in_a_tree(trace: Trace) -> None:
    trace.vehicles["p1"].states[100:110, 1:3] = (12.0, -8.0)  # 0.6 m of trunk and 0.35 m of body, 1 m from its middle
    trace.vehicles["p1"].states[105, 2] = -7.9


def two_meet(trace: Trace) -> None:
    one, other = trace.vehicles["p1"], trace.vehicles["p2"]
    one.states[100, 1:4] = other.states[100, 1:4] + (-0.6, 0.0, 0.0)
    one.states[100, 4] = 1.0


def setpoint_after_takeover(trace: Trace) -> None:
    trace.vehicles["p1"].takeovers.append(Takeover(5.0, 5.1))
    trace.vehicles["p1"].transmitted_s.clear()


def repeats_after_takeover(trace: Trace) -> None:
    one = trace.vehicles["p1"]
    one.takeovers.append(Takeover(5.0, 5.1))
    one.setpoints = [sent for sent in one.setpoints if sent.t_s < 5.1]


def command_after_takeover(trace: Trace) -> None:
    taken(trace)
    trace.vehicles["p1"].commands.append((6.0, "return"))


def offboard_after_a_wish(trace: Trace) -> None:
    taken(trace)
    trace.vehicles["p1"].wishes.append(Wish(5.5, "rtl", True, 5.6, accepted=True))
    trace.vehicles["p1"].commands.append((6.0, "OFFBOARD"))


def taken(trace: Trace) -> None:
    """The pilot takes over at 5 s and the app does what it must."""
    one = trace.vehicles["p1"]
    one.takeovers.append(Takeover(5.0, 5.1))
    one.setpoints = [sent for sent in one.setpoints if sent.t_s < 5.1]
    one.transmitted_s = [t_s for t_s in one.transmitted_s if t_s < 5.1]


def heard_late(trace: Trace) -> None:
    taken(trace)
    trace.vehicles["p1"].takeovers[0].heard_s = 5.3


def never_heard(trace: Trace) -> None:
    trace.vehicles["p1"].takeovers.append(Takeover(5.0))


def unanswered(trace: Trace) -> None:
    trace.vehicles["p1"].wishes.append(Wish(5.0, "land", True, None, accepted=False))


def answered_late(trace: Trace) -> None:
    trace.vehicles["p1"].wishes.append(Wish(5.0, "land", True, 5.3, accepted=True))


def not_readable(trace: Trace) -> None:
    trace.vehicles["p1"].recordings.append(RecordingCheck(Path("p1.cut.mcap"), 0, "is no recording"))


def empty_recording(trace: Trace) -> None:
    trace.vehicles["p1"].recordings[0] = RecordingCheck(Path("p1.mcap"), 0, "")


def not_recorded(trace: Trace) -> None:
    trace.vehicles["p1"].recordings.clear()


def left_in_the_air(trace: Trace) -> None:
    trace.vehicles["p1"].on_ground[-1] = False


def left_armed(trace: Trace) -> None:
    trace.vehicles["p1"].armed[-1] = True


def crashed(trace: Trace) -> None:
    trace.vehicles["p1"].crashes.append("ValueError: x")


def left_over(trace: Trace) -> None:
    trace.leftovers.append("a recorder's thread lives on")


def test_nothing_is_wrong_with_a_calm_trace() -> None:
    assert violated(calm_trace()) == []


BROKEN = [
    (outside, "contingency volume", "p1"),
    (too_high, "contingency volume", "p1"),
    (too_fast, "setpoint limits", "p1"),
    (above_its_own_limit, "setpoint limits", "e1"),
    (climbing_too_fast, "setpoint limits", "p1"),
    (changing_too_fast, "setpoint limits", "p1"),
    (turning_too_fast, "setpoint limits", "p1"),
    (not_finite, "setpoint limits", "p1"),
    (in_a_tree, "obstacle contact", "p1"),
    (two_meet, "vehicle contact", "p1"),
    (setpoint_after_takeover, "takeover", "p1"),
    (repeats_after_takeover, "takeover", "p1"),
    (command_after_takeover, "takeover", "p1"),
    (offboard_after_a_wish, "takeover", "p1"),
    (heard_late, "takeover seen", "p1"),
    (never_heard, "takeover seen", "p1"),
    (unanswered, "acknowledgement", "p1"),
    (answered_late, "acknowledgement", "p1"),
    (not_readable, "recordings", "p1"),
    (empty_recording, "recordings", "p1"),
    (not_recorded, "recordings", "p1"),
    (left_in_the_air, "on the ground", "p1"),
    (left_armed, "on the ground", "p1"),
    (crashed, "no crash", "p1"),
    (left_over, "no crash", ""),
]


@pytest.mark.parametrize(("break_it", "invariant", "vehicle"), BROKEN, ids=[case[0].__name__ for case in BROKEN])
def test_what_is_broken_is_found_and_nothing_else(break_it, invariant, vehicle) -> None:  # type: ignore[no-untyped-def]
    trace = calm_trace()
    break_it(trace)
    assert violated(trace) == [(invariant, vehicle)]


def test_every_invariant_has_been_broken() -> None:
    assert {invariant for _, invariant, _ in BROKEN} == set(INVARIANTS)


@pytest.mark.parametrize("break_it", [outside, in_a_tree, two_meet])
def test_the_app_does_not_answer_for_the_place_after_a_fault_that_misleads_it(break_it) -> None:  # type: ignore[no-untyped-def]
    trace = calm_trace(felt("gps wrong", "p1", 1.0, excuses=True))
    break_it(trace)
    assert violated(trace) == []


@pytest.mark.parametrize("break_it", [outside, in_a_tree, two_meet])
def test_it_answers_until_then_and_after_every_other_fault(break_it) -> None:  # type: ignore[no-untyped-def]
    trace = calm_trace(felt("gps wrong", "p1", 3.0, excuses=True), felt("camera off", "p1", 1.0, excuses=False))
    break_it(trace)
    assert [vehicle for _, vehicle in violated(trace)] == ["p1"]


def test_a_pilot_flies_where_a_pilot_wants() -> None:
    trace = calm_trace()
    taken(trace)
    trace.vehicles["p1"].states[400 : STEPS - 1, 1] = -30.0
    assert violated(trace) == []


def test_braking_and_what_the_spatial_guards_force_may_be_hard() -> None:
    trace = calm_trace()
    resend(trace, "p1", 100, SentSetpoint(0.0, (0.0, 0.0, 0.0), 0.0, ()))
    resend(trace, "p1", 200, SentSetpoint(0.0, (-1.0, 0.0, 0.0), 0.0, ("separation",)))
    resend(trace, "p1", 201, SentSetpoint(0.0, (-0.0, 0.0, 0.0), 0.0, ()))
    assert violated(trace) == []


def test_who_was_hit_has_not_hit() -> None:
    trace = calm_trace()
    two_meet(trace)
    trace.vehicles["p1"].states[100, 4] = 0.0
    trace.vehicles["p2"].states[100, 4] = 0.0
    assert violated(trace) == []


def test_commands_that_a_person_asked_for_may_follow_a_takeover() -> None:
    trace = calm_trace()
    taken(trace)
    trace.vehicles["p1"].wishes.append(Wish(5.5, "rtl", True, 5.6, accepted=True))
    trace.vehicles["p1"].commands.append((5.6, "return"))
    assert violated(trace) == []


def test_a_takeover_that_the_link_hides_need_not_be_seen_at_once() -> None:
    trace = calm_trace(felt("link down off", "p1", 4.0, excuses=False))
    heard_late(trace)
    assert violated(trace) == []

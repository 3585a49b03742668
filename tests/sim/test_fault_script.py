"""The fault script: what it accepts, what it refuses and how, and that each verb on each target is felt."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from flightapp.core.errors import InputError
from flightapp.sim.autopilot_modes import Mode
from flightapp.sim.fault_script import FIELDS, load_fault_script
from flightapp.sim.mavlink_dialect import mavlink
from tests.sim.virtual_mock import VirtualMock

CASES = [(target, verb) for target, verbs in FIELDS.items() for verb in verbs]


@pytest.mark.parametrize(("target", "verb"), CASES)
def test_each_verb_on_each_target_begins_is_felt_and_ends(target: str, verb: str) -> None:
    """A short flight with commands: what a fault needs to have something to act on."""
    on_ground = target == "arming"
    start_s = 0.5 if on_ground else 4.0
    fault = {"target": target, "verb": verb, "at_s": start_s, "duration_s": 3.0}
    mock = VirtualMock(fault, parameters={"MIS_TAKEOFF_ALT": 1.0})
    if on_ground:
        mock.run(1.0)
        for _ in range(10):
            mock.arm(settle_s=0.3)
            mock.disarm()
        mock.run(1.0)
    else:
        mock.take_off()
        mock.fly_offboard(1.0, 0.5)
        mock.run_until(lambda: mock.core.t_s > 4.8)
        mock.stream = mock.velocity(0.0, -1.0, 0.0)
        mock.mode(Mode.HOLD)
        mock.run(3.0)
    assert mock.fault_events()[:2] == ["fault_began", "fault_felt"]
    assert "fault_ended" in mock.fault_events()
    assert not mock.faults.unfelt()


@pytest.mark.parametrize(("target", "verb"), [case for case in CASES if case[0] not in ("link", "link_down", "link_up")])
def test_the_fault_is_told_as_a_status_text(target: str, verb: str) -> None:
    mock = VirtualMock({"target": target, "verb": verb, "at_s": 0.1, "duration_s": 1.0})
    mock.run(0.5)
    assert f"Fault began: {target} {verb}" in mock.texts()


def flying(*faults: dict[str, Any], **options: Any) -> VirtualMock:
    mock = VirtualMock(*({"when": {"mode": "OFFBOARD", "after_s": 1.0}, **fault} for fault in faults), **options)
    mock.take_off()
    mock.fly_offboard(1.0)
    mock.run_until(lambda: "fault_began" in mock.fault_events())
    mock.messages.clear()
    return mock


def test_a_dead_link_carries_nothing_in_either_direction() -> None:
    mock = flying({"target": "link", "verb": "off"})
    mock.run(2.0)
    assert not mock.messages
    assert mock.core.mode is Mode.POSCTL


def test_a_dead_uplink_still_shows_the_failsafe() -> None:
    mock = flying({"target": "link_up", "verb": "off", "duration_s": 3.0})
    mock.run(2.0)
    assert mock.newest("HEARTBEAT").custom_mode == Mode.POSCTL.custom_mode
    mock.run(2.0)
    assert mock.core.mode is Mode.OFFBOARD


def test_stuck_telemetry_repeats_values_under_running_time() -> None:
    mock = flying({"target": "telemetry", "verb": "stuck"})
    mock.run(1.0)
    positions = mock.all("LOCAL_POSITION_NED")
    assert len({message.x for message in positions}) == 1
    assert len({message.time_boot_ms for message in positions}) == len(positions) > 40


def test_telemetry_off_leaves_heartbeats_and_acknowledgements() -> None:
    mock = flying({"target": "telemetry", "verb": "off"})
    mock.run(2.0)
    assert mock.all("HEARTBEAT")
    assert not mock.all("LOCAL_POSITION_NED")
    assert mock.mode(Mode.HOLD) == 0


def test_garbage_telemetry_is_broken_or_finite_nonsense() -> None:
    mock = flying({"target": "telemetry", "verb": "garbage", "fraction": 1.0})
    mock.run(2.0)
    assert mock.all("BAD_DATA")
    assert any(abs(message.x) > 100.0 for message in mock.all("LOCAL_POSITION_NED"))


def test_delayed_link_is_late_by_the_given_time() -> None:
    mock = flying({"target": "link_down", "verb": "delayed", "delay_s": 0.7})
    mock.run(1.5)
    assert mock.core.t_s * 1e3 - mock.newest("LOCAL_POSITION_NED").time_boot_ms == pytest.approx(700.0, abs=30.0)


def test_slow_telemetry_divides_the_rate() -> None:
    mock = flying({"target": "telemetry", "verb": "slow", "factor": 5.0})
    mock.run(0.5)
    mock.messages.clear()
    mock.run(2.0)
    assert len(mock.all("LOCAL_POSITION_NED")) == pytest.approx(20, abs=1)


def test_wrong_telemetry_shifts_what_is_reported_not_what_is_flown() -> None:
    mock = flying({"target": "telemetry", "verb": "wrong", "offset_m": 12.0})
    mock.run(0.1)
    local = mock.core.frames.to_local(mock.core.vehicle.position_ned_m)
    assert mock.newest("LOCAL_POSITION_NED").x - local[0] == pytest.approx(12.0, abs=0.1)


def test_a_wrong_system_id_on_the_way_down_and_up() -> None:
    mock = flying({"target": "link_down", "verb": "wrong", "system_id": 77})
    mock.run(0.5)
    assert {message.get_srcSystem() for message in mock.messages} == {77}
    mock = flying({"target": "link_up", "verb": "wrong", "system_id": 77})
    assert mock.mode(Mode.HOLD) is None
    mock.run(1.5)
    assert mock.core.mode is Mode.POSCTL


def test_dead_motors_fall_and_weak_motors_sink() -> None:
    mock = flying({"target": "motors", "verb": "off"})
    mock.run_until(lambda: mock.core.vehicle.on_ground, 3.0)
    assert [event for event in mock.events if event["event"] == "impact"] or mock.core.vehicle.impact_speed_m_s > 3.0
    mock = flying({"target": "motors", "verb": "slow", "fraction": 0.42})
    mock.run(1.0)
    assert mock.core.vehicle.velocity_ned_m_s[2] > 0.2


def test_a_gps_offset_pulls_the_vehicle_away() -> None:
    mock = flying({"target": "gps", "verb": "wrong", "offset_m": 3.0})
    mock.stream = mock.velocity(0.0, 0.0, 0.0)
    mock.run(8.0)
    reported = mock.newest("LOCAL_POSITION_NED").x
    true = mock.core.frames.to_local(mock.core.vehicle.position_ned_m)[0]
    assert reported - true == pytest.approx(3.0, abs=0.2)


@pytest.mark.parametrize(
    ("verb", "result", "armed"),
    [("off", 1, False), ("stuck", 2, False), ("wrong", 0, False), ("slow", 0, False), ("delayed", None, False)],
)
def test_arming_faults_answer_as_they_should(verb: str, result: int | None, armed: bool) -> None:
    mock = VirtualMock({"target": "arming", "verb": verb, "at_s": 0.1})
    mock.run(1.0)
    assert mock.arm() == result
    mock.run(0.1)
    assert mock.core.armed is armed
    mock.run(2.5)
    assert mock.core.armed is (verb in ("slow", "delayed"))
    if verb in ("off", "stuck"):
        assert any(text.startswith("Preflight Fail") for text in mock.texts())


def test_an_empty_battery_reports_itself() -> None:
    mock = flying({"target": "battery", "verb": "off"})
    mock.run(2.0)
    assert mock.newest("BATTERY_STATUS").battery_remaining == 0
    assert mock.newest("BATTERY_STATUS").charge_state == mavlink.MAV_BATTERY_CHARGE_STATE_EMERGENCY
    assert "Emergency battery level" in [event.get("text") for event in mock.events]


def test_a_fault_whose_condition_never_comes_is_unfelt() -> None:
    mock = VirtualMock({"target": "gps", "verb": "off", "when": {"height_above_m": 50.0}})
    mock.take_off()
    assert [active.name for active in mock.faults.unfelt()] == ["gps off"]
    assert not mock.fault_events()


def test_of_two_faults_on_a_target_the_later_acts_then_the_earlier_again() -> None:
    always = {"armed": False}
    mock = VirtualMock(
        {"target": "battery", "verb": "wrong", "remaining": 0.5, "when": always},
        {"target": "battery", "verb": "wrong", "remaining": 0.2, "when": {**always, "after_s": 1.0}, "duration_s": 1.0},
    )
    seen = []
    for _ in range(3):
        mock.run(0.9)
        seen.append(mock.core.battery.remaining)
    assert seen == [0.5, 0.2, 0.5]


REFUSED = [
    ('target = "gsp"\nverb = "off"\nat_s = 1.0', "faults[0].target = 'gsp'"),
    ('target = "gps"\nverb = "of"\nat_s = 1.0', "faults[0].verb = 'of'"),
    ('target = "gps"\nverb = "off"', "give at_s or when; neither is given"),
    ('target = "gps"\nverb = "off"\nat_s = 1.0\nwhen = { armed = true }', "both are given"),
    ('target = "gps"\nverb = "off"\nat_s = 1.0\noffset_m = 2.0', "offset_m = 2.0 means nothing to gps off"),
    ('target = "gps"\nverb = "wrong"\nat_s = 1.0\ndelay_s = 2.0', "it takes offset_m"),
    ('target = "gps"\nverb = "off"\nwhen = { after_s = 2.0 }', "nothing to wait for"),
    ('target = "gps"\nverb = "off"\nwhen = { height_above_m = 5.0, height_below_m = 2.0 }', "never true"),
    ('target = "gps"\nverb = "off"\nat_s = -1.0', "faults[0].at_s = -1.0"),
    ('target = "gps"\nverb = "off"\nat = 1.0', "did you mean 'at_s'?"),
    (
        'target = "gps"\nverb = "off"\nat_s = 1.0\n[[faults]]\ntarget = "gps"\nverb = "stuck"\nat_s = 2.0',
        "faults[1] (gps stuck) and faults[0] (gps off) contradict",
    ),
    (
        'target = "link"\nverb = "off"\nat_s = 5.0\nduration_s = 2.0\n[[faults]]\ntarget = "link_up"\nverb = "slow"\nat_s = 6.0',
        "contradict",
    ),
]


@pytest.mark.parametrize(("text", "expected"), REFUSED)
def test_a_wrong_script_is_refused_with_one_clear_sentence(tmp_path: Path, text: str, expected: str) -> None:
    path = tmp_path / "faults.toml"
    path.write_text(f"[[faults]]\n{text}\n", encoding="utf-8")
    with pytest.raises(InputError) as refusal:
        load_fault_script(path)
    assert str(path) in str(refusal.value)
    assert expected in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_faults_one_after_the_other_are_accepted(tmp_path: Path) -> None:
    path = tmp_path / "faults.toml"
    path.write_text(
        '[[faults]]\ntarget = "gps"\nverb = "off"\nat_s = 1.0\nduration_s = 2.0\n'
        '[[faults]]\ntarget = "gps"\nverb = "wrong"\nat_s = 3.0\noffset_m = 2.0\n',
        encoding="utf-8",
    )
    assert len(load_fault_script(path).faults) == 2

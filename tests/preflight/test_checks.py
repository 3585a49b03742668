"""Each check against a vehicle that is ready, and against one that is not: level, and words that help."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from flightapp.core.errors import InputError
from flightapp.core.types import VehicleState
from flightapp.preflight.checklist import refuse_unknown, run_checklist
from flightapp.preflight.facts import ComputerFacts, Facts, RecorderFacts, WayFacts
from flightapp.preflight.px4_parameters import needed_parameters
from flightapp.preflight.result import Level, Result, is_ready
from flightapp.vehicle.autopilot import Accuracy, BatteryState, HealthState, Motion, Status
from tests.preflight.good_facts import (
    MISSION,
    NOW_S,
    PROFILE,
    VEHICLE,
    good_facts,
    with_camera,
    with_details,
    with_parameter,
    with_teammate,
)


def result_of(facts: Facts, check: str) -> Result:
    found = [result for result in run_checklist(facts) if result.check == check]
    assert len(found) == 1, (check, found)
    return found[0]


def away(north_m: float, up_m: float) -> Motion:
    start = VEHICLE.start
    place = np.array([start.north_m + north_m, start.east_m, -start.ground_height_m - up_m])
    return Motion(VehicleState(NOW_S, place, np.zeros(3), 0.0), 0.0, 0.0, NOW_S)


def over(endpoint: str, **changes: Any) -> Facts:
    network = PROFILE.network.model_copy(update={"connect_endpoints": (endpoint,), **changes})
    return good_facts(profile=PROFILE.model_copy(update={"network": network}))


def test_a_good_vehicle_is_ready_and_every_result_says_why_it_matters() -> None:
    results = run_checklist(good_facts())
    assert is_ready(results)
    assert {result.level for result in results} <= {Level.PASSED, Level.SKIPPED, Level.NOTED}
    assert all(result.reason and result.found for result in results)
    assert len({result.check for result in results}) == len(results)


NOT_READY = {
    "no heartbeat": (good_facts(status=Status(False, "HOLD", False, "ON_GROUND", 0.0)), "link", Level.FAILED),
    "slow telemetry": (with_details(state_rate_hz=10.0), "link", Level.FAILED),
    "stuttering telemetry": (with_details(telemetry_gap_s=0.4), "link", Level.WARNING),
    "transmitter off": (with_details(transmitter_seen=False), "transmitter", Level.FAILED),
    "transmitter not told": (with_details(transmitter_seen=None), "transmitter", Level.WARNING),
    "ArduPilot": (with_details(autopilot="ArduPilot"), "autopilot", Level.FAILED),
    "old firmware": (with_details(version=(1, 11, 3)), "autopilot", Level.FAILED),
    "version unknown": (with_details(version=None), "autopilot", Level.WARNING),
    "a twin on the link": (with_details(twin="times jump to and fro"), "system-id", Level.FAILED),
    "a teammate with the same id": (with_teammate(system_id=VEHICLE.system_id), "system-id", Level.FAILED),
    "armed": (good_facts(status=Status(True, "HOLD", True, "ON_GROUND", NOW_S)), "health", Level.FAILED),
    "GPS converging": (good_facts(health=HealthState(False, True, True, True)), "health", Level.RUNNING),
    "no position": (good_facts(motion=None), "position", Level.RUNNING),
    "2-D fix": (with_details(accuracy=Accuracy(5, 2, 0.8, 1.2)), "position", Level.RUNNING),
    "poor accuracy": (with_details(accuracy=Accuracy(5, 3, 9.0, 12.0)), "position", Level.RUNNING),
    "accuracy not told": (with_details(accuracy=Accuracy(14, 3, np.nan, np.nan)), "position", Level.NOTED),
    "wrong place": (good_facts(motion=away(30.0, 0.0)), "start", Level.FAILED),
    "wrong height": (good_facts(motion=away(0.0, 20.0)), "start", Level.FAILED),
    "no home": (with_details(home_ned_m=None), "home", Level.RUNNING),
    "home elsewhere": (with_details(home_ned_m=(500.0, 0.0, 0.0)), "home", Level.FAILED),
    "battery low": (good_facts(battery=BatteryState(14.2, 0.3)), "battery", Level.FAILED),
    "battery not full": (good_facts(battery=BatteryState(15.9, 0.8)), "battery", Level.NOTED),
    "battery without charge": (good_facts(battery=BatteryState(15.9, None)), "battery", Level.WARNING),
    "battery not reported": (good_facts(battery=None), "battery", Level.RUNNING),
    "no frame": (with_camera(frame_age_s=None), "camera", Level.FAILED),
    "old frame": (with_camera(frame_age_s=2.0), "camera", Level.FAILED),
    "camera fault": (with_camera(fault="RealSense unplugged"), "camera", Level.FAILED),
    "camera slow": (with_camera(rate_hz=12.0), "camera", Level.WARNING),
    "camera late": (with_camera(latency_s=0.3), "camera", Level.WARNING),
    "camera on USB 2": (with_camera(warning="connected over USB 2.1"), "camera", Level.WARNING),
    "camera restarted": (with_camera(restarts=2), "camera", Level.WARNING),
    "camera missing": (good_facts(camera=None), "camera", Level.SKIPPED if PROFILE.camera.source != "none" else Level.FAILED),
    "plain UDP": (over("udp/10.0.0.2:7447"), "fleet-links", Level.WARNING),
    "a way to the station": (good_facts(ways=(WayFacts(True, "ingress of 40 m"),)), "planned-ways", Level.PASSED),
    "no way to the station": (good_facts(ways=(WayFacts(False, "no ingress"),)), "planned-ways", Level.FAILED),
    "less than the fleet sends": (over("quic/10.0.0.2:7447", fleet_kbit_s_max=1.0), "fleet-budget", Level.WARNING),
    "QUIC": (over("quic/10.0.0.2:7447"), "fleet-links", Level.PASSED),
    "on one machine": (over("udp/127.0.0.1:7447"), "fleet-links", Level.PASSED),
    "teammate not heard": (with_teammate(age_s=None), "team", Level.RUNNING),
    "teammate silent": (with_teammate(age_s=4.0), "team", Level.RUNNING),
    "another mission file": (with_teammate(mission_digest="xyz"), "mission-file", Level.FAILED),
    "clock ahead": (with_teammate(clock_ahead_s=0.4), "clock", Level.FAILED),
    "clock behind": (with_teammate(clock_ahead_s=-2.0), "clock", Level.FAILED),
    "clock corrected, a day off": (with_teammate(clock_ahead_s=-0.002, clock_measured_s=86_400.0), "clock", Level.WARNING),
    "clock free": (good_facts(computer=ComputerFacts(10**11, ("performance",), False)), "clock", Level.WARNING),
    "disk full": (good_facts(computer=ComputerFacts(10**6, ("performance",), True)), "disk", Level.FAILED),
    "disk slow": (good_facts(recorder=RecorderFacts(0.3)), "storage", Level.WARNING),
    "disk hangs": (good_facts(recorder=RecorderFacts(2.5)), "storage", Level.FAILED),
    "nothing is recorded any more": (
        good_facts(recorder=RecorderFacts(0.01, "No space left on device")),
        "storage",
        Level.FAILED,
    ),
    "velocity loop tuned otherwise": (with_parameter("MPC_XY_VEL_P_ACC", 2.6), "MPC_XY_VEL_P_ACC", Level.WARNING),
    "velocity loop unknown": (with_parameter("MPC_Z_VEL_P_ACC", None), "MPC_Z_VEL_P_ACC", Level.WARNING),
    "disk nearly full": (good_facts(computer=ComputerFacts(10**9, ("performance",), True)), "disk", Level.WARNING),
    "powersave": (good_facts(computer=ComputerFacts(10**11, ("powersave",), True)), "cpu-governor", Level.WARNING),
    "governor not told": (good_facts(computer=ComputerFacts(10**11, (), True)), "cpu-governor", Level.SKIPPED),
}


@pytest.mark.parametrize("name", NOT_READY)
def test_what_is_not_right_is_found(name: str) -> None:
    facts, check, level = NOT_READY[name]
    result = result_of(facts, check)
    assert result.level is level
    if level in (Level.FAILED, Level.WARNING, Level.RUNNING):
        assert result.remedy
        assert is_ready(run_checklist(facts)) is (level is Level.WARNING)


def test_what_converges_is_running_at_first_and_fails_only_later() -> None:
    silent = good_facts(status=Status(False, "UNKNOWN", False, "UNKNOWN", 0.0), waited_s=0.5)
    assert result_of(silent, "link").level is Level.RUNNING
    early = with_camera(frame_age_s=None)
    early = good_facts(camera=early.camera, waited_s=1.0)
    assert result_of(early, "camera").level is Level.RUNNING


WRONG_PARAMETERS = {
    "COM_OF_LOSS_T": (5.0, Level.FAILED),
    "COM_OBL_RC_ACT": (0, Level.FAILED),
    "COM_OBL_ACT": (-1, Level.FAILED),
    "COM_RC_OVERRIDE": (1, Level.FAILED),
    "COM_RCL_EXCEPT": (4, Level.FAILED),
    "SYS_FAILURE_EN": (1, Level.FAILED),
    "GF_ACTION": (0, Level.WARNING),
    "GF_MAX_HOR_DIST": (10.0, Level.FAILED),
    "GF_MAX_VER_DIST": (2.0, Level.FAILED),
    "MPC_XY_VEL_MAX": (2.0, Level.FAILED),
    "MPC_ACC_HOR_MAX": (1.0, Level.FAILED),
    "MPC_ACC_HOR": (1.0, Level.WARNING),
    "MPC_JERK_MAX": (4.0, Level.WARNING),
    "MPC_Z_VEL_MAX_UP": (0.5, Level.FAILED),
    "MPC_Z_VEL_MAX_DN": (0.5, Level.WARNING),
    "MPC_YAWRAUTO_MAX": (20.0, Level.WARNING),
    "MAV_SYS_ID": (99, Level.FAILED),
    "COM_LOW_BAT_ACT": (0, Level.FAILED),
}


def test_every_parameter_of_the_table_is_tried_with_a_wrong_value() -> None:
    assert set(WRONG_PARAMETERS) == {rule.name for rule in needed_parameters(MISSION, PROFILE, VEHICLE)}


@pytest.mark.parametrize("name", WRONG_PARAMETERS)
def test_a_wrong_parameter_is_found_with_its_value_and_reason(name: str) -> None:
    value, level = WRONG_PARAMETERS[name]
    result = result_of(with_parameter(name, value), name)
    assert result.level is level
    assert f"{value:g}" in result.found
    assert "wanted" in result.found


@pytest.mark.parametrize("name", WRONG_PARAMETERS)
def test_what_would_be_written_is_right(name: str) -> None:
    rule = next(rule for rule in needed_parameters(MISSION, PROFILE, VEHICLE) if rule.name == name)
    assert rule.is_right(rule.write)


def test_a_parameter_that_is_not_answered_fails_unless_its_version_has_none() -> None:
    assert result_of(with_parameter("COM_RC_OVERRIDE", None), "COM_RC_OVERRIDE").level is Level.FAILED
    assert result_of(with_parameter("COM_OBL_ACT", None), "COM_OBL_ACT").level is Level.SKIPPED


def test_without_a_transmitter_offboard_must_be_excepted_from_its_loss() -> None:
    profile = PROFILE.model_copy(update={"autopilot": PROFILE.autopilot.model_copy(update={"pilot_transmitter": False})})
    parameters = {rule.name: rule.write for rule in needed_parameters(MISSION, profile, VEHICLE)}
    assert parameters["COM_RCL_EXCEPT"] == 4
    facts = good_facts(profile=profile, parameters={**parameters, "COM_RCL_EXCEPT": 0})
    assert result_of(facts, "COM_RCL_EXCEPT").level is Level.FAILED


def test_a_vehicle_without_a_pilot_is_asked_for_no_transmitter() -> None:
    profile = PROFILE.model_copy(update={"autopilot": PROFILE.autopilot.model_copy(update={"pilot_transmitter": False})})
    facts = with_details(transmitter_seen=False)
    assert result_of(replace(facts, profile=profile), "transmitter").level is Level.SKIPPED


@pytest.mark.parametrize(("fix", "word"), [(3, "3-D fix"), (5, "RTK float"), (6, "RTK fixed")])
def test_a_receiver_that_converges_shows_how_far_it_is(fix: int, word: str) -> None:
    result = result_of(with_details(accuracy=Accuracy(14, fix, 0.8, 1.2)), "position")
    assert result.level is Level.PASSED
    assert word in result.found


def test_a_waiver_by_name_lets_fly_and_stays_visible() -> None:
    facts = good_facts(battery=BatteryState(14.2, 0.3))
    assert not is_ready(run_checklist(facts))
    results = run_checklist(facts, ["battery"])
    assert is_ready(results)
    assert [result.check for result in results if result.level is Level.WAIVED] == ["battery"]


def test_what_still_runs_cannot_be_waived() -> None:
    facts = good_facts(health=HealthState(False, True, True, True))
    assert not is_ready(run_checklist(facts, ["health"]))


def test_a_waiver_of_nothing_is_refused() -> None:
    with pytest.raises(InputError, match="no such check; known: link, autopilot"):
        refuse_unknown(["batery"], run_checklist(good_facts()))

"""Facts of a vehicle that is ready to fly, to be spoilt one by one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from flightapp.config.mission import load_mission
from flightapp.config.profile import load_profile
from flightapp.core.types import VehicleState
from flightapp.preflight.facts import CameraFacts, ComputerFacts, Facts, RecorderFacts, TeammateFacts
from flightapp.preflight.px4_parameters import needed_parameters
from flightapp.vehicle.autopilot import Accuracy, AutopilotDetails, BatteryState, HealthState, Motion, Status

ROOT = Path(__file__).parents[2]
MISSION = load_mission(ROOT / "missions/demo_two_pursuers.toml")
PROFILE = load_profile(ROOT / "profiles/sim.toml")
VEHICLE = next(vehicle for vehicle in MISSION.vehicles if vehicle.role == "pursuer")
NOW_S = 1000.0


def good_facts(**changes: Any) -> Facts:
    start = VEHICLE.start
    at = np.array([start.north_m, start.east_m, -start.ground_height_m])
    details = AutopilotDetails(
        autopilot="PX4",
        version=(1, 16, 1),
        hardware_uid="00",
        system_ids_heard=(VEHICLE.system_id,),
        twin="",
        state_rate_hz=50.0,
        attitude_rate_hz=50.0,
        accuracy=Accuracy(14, 3, 0.8, 1.2),
        home_ned_m=(float(at[0]), float(at[1]), float(at[2])),
        transmitter_seen=True,
    )
    facts = Facts(
        t_s=NOW_S,
        waited_s=20.0,
        mission=MISSION,
        mission_digest="abc",
        profile=PROFILE,
        vehicle=VEHICLE,
        status=Status(True, "HOLD", False, "ON_GROUND", NOW_S),
        health=HealthState(True, True, True, True),
        motion=Motion(VehicleState(NOW_S, at, np.zeros(3), 0.0), 0.0, 0.0, NOW_S),
        motion_age_s=0.02,
        battery=BatteryState(16.8, 1.0),
        details=details,
        parameters={rule.name: rule.write for rule in needed_parameters(MISSION, PROFILE, VEHICLE)},
        camera=CameraFacts(0.02, 0.012, 30.0, "", "", 0),
        teammates=tuple(
            TeammateFacts(other.name, 0.05, "abc", other.system_id, -0.002) for other in MISSION.vehicles if other is not VEHICLE
        ),
        computer=ComputerFacts(10**11, ("performance",), True),
        recorder=RecorderFacts(0.002),
    )
    return replace(facts, **changes)


def with_details(**changes: Any) -> Facts:
    return good_facts(details=replace(good_facts().details, **changes))


def with_camera(**changes: Any) -> Facts:
    camera = good_facts().camera
    assert camera is not None
    return good_facts(camera=replace(camera, **changes))


def with_teammate(**changes: Any) -> Facts:
    first, *others = good_facts().teammates
    return good_facts(teammates=(replace(first, **changes), *others))


def with_parameter(name: str, value: float | None) -> Facts:
    return good_facts(parameters={**good_facts().parameters, name: value})

"""All measurements in one process, one after the other."""

from __future__ import annotations

import gc
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from flightapp.bench.adaptive_apf import adaptive_apf_measurements
from flightapp.bench.camera import camera_measurements
from flightapp.bench.control import controller_measurement
from flightapp.bench.encirclement import encirclement_measurements
from flightapp.bench.hunting import hunting_measurements
from flightapp.bench.machine import machine
from flightapp.bench.measurement import Measurement
from flightapp.bench.memory import memory_use
from flightapp.bench.orca import ORCA_DECISION, orca_measurements
from flightapp.bench.output import fleet_measurement, recorder_measurement
from flightapp.bench.paths import path_measurements
from flightapp.bench.perception_load import perception_load
from flightapp.bench.planner import DECISIONS, planner_measurements
from flightapp.bench.realsense_sdk import SDK_ROW
from flightapp.bench.safety import supervisor_measurement
from flightapp.bench.simulator import simulator_throughput
from flightapp.config.mission import Mission, Vehicle, load_mission
from flightapp.config.profile import Profile, load_profile
from flightapp.core.errors import InputError
from flightapp.core.types import Limits
from flightapp.runtime.composition import limits_of

NO_PYRVO = "pyrvo is not installed; it is in the extra 'dev'"
NO_SDK = "pyrealsense2 cannot be imported; it is in the extra 'realsense' and needs libusb-1.0-0"
STEPS_A_FRAME = 4
"""Perception takes longer than a decision: it gets this much fewer frames than the planner gets steps."""


def run_bench(mission: Path, profile: Path, scenario: Path, seconds: float = 20.0, steps: int = 20_000) -> dict[str, object]:
    """Measure for about `seconds`, and then memory over `steps` decisions and a fourth as many depth frames.

    With the obstacles of `mission`, the limits and camera of `profile`, and the fast simulation of `scenario`. Returns the
    machine; for each measurement name, repetitions, wall_ms and cpu_ms (p50, p99, max), aim_ms (of the 99th percentile) with
    its verdict, how many times faster it is than its plain reference, than ORCA and than the RealSense SDK's first steps; what
    could not be measured and why; the simulator's rate; perception's rate and memory; the planner's memory.
    """
    loaded, hardware = load_mission(mission), load_profile(profile)
    vehicle = next((one for one in loaded.vehicles if one.role == "pursuer"), None)
    if vehicle is None:
        raise InputError(f"{mission}: vehicles: no pursuer, so there is no planner to measure")
    limits = limits_of(vehicle, hardware)
    with _frozen_garbage():
        return _measured(loaded, hardware, vehicle, limits, scenario, seconds, steps)


@contextmanager
def _frozen_garbage() -> Iterator[None]:
    """As a vehicle process before take-off: what is there by now is never searched for garbage again."""
    gc.collect()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()


def _measured(
    loaded: Mission, hardware: Profile, vehicle: Vehicle, limits: Limits, scenario: Path, seconds: float, steps: int
) -> dict[str, object]:
    before = machine()
    decisions, missing = _decisions(limits, 0.4 * seconds)
    depth = camera_measurements(loaded, hardware, vehicle, 0.25 * seconds)
    if SDK_ROW not in {one.name for one in depth}:
        missing.append({"name": SDK_ROW, "why": NO_SDK})
    measurements = [
        *decisions,
        *encirclement_measurements(limits, 0.05 * seconds),
        *hunting_measurements(limits, 0.05 * seconds),
        *adaptive_apf_measurements(limits, 0.05 * seconds),
        *depth,
        supervisor_measurement(loaded, hardware, vehicle, limits, 0.1 * seconds),
        recorder_measurement(limits, 0.1 * seconds),
        fleet_measurement(0.05 * seconds),
        controller_measurement(0.02 * seconds),
        *path_measurements(0.1 * seconds),
    ]
    frame_rate, frame_memory = perception_load(hardware, steps // STEPS_A_FRAME)
    return {
        "machine": before,
        "measurements": [_plain(one) for one in measurements],
        "not_measured": missing,
        "simulator": _plain(simulator_throughput(scenario, 0.1 * seconds)),
        "frame_rate": _plain(frame_rate),
        "frame_memory": _plain(frame_memory),
        "memory": _plain(memory_use(limits, steps)),
    }


def _decisions(limits: Limits, seconds: float) -> tuple[list[Measurement], list[dict[str, str]]]:
    """The planner's rows beside ORCA's, and what is missing of them."""
    planner = planner_measurements(limits, 0.8 * seconds)
    orca = orca_measurements(limits, 0.2 * seconds)
    if orca is None:
        return planner, [{"name": ORCA_DECISION, "why": NO_PYRVO}]
    return [*_beside_orca(planner, orca), *orca], []


def _beside_orca(planner: Sequence[Measurement], orca: Sequence[Measurement]) -> list[Measurement]:
    """The planner's rows with the ratio of ORCA's time for a decision to their own."""
    decision = next(one for one in orca if one.name == ORCA_DECISION)
    return [replace(one, orca_ratio=decision.cpu_ms.p50 / one.cpu_ms.p50) if one.name in DECISIONS else one for one in planner]


def _plain(found: Any) -> dict[str, object]:
    return {**asdict(found), "verdict": found.verdict}

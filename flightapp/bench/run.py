"""All measurements in one process, one after the other."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from flightapp.bench.camera import camera_measurements
from flightapp.bench.machine import machine
from flightapp.bench.measurement import Measurement
from flightapp.bench.output import fleet_measurement, recorder_measurement
from flightapp.bench.planner import planner_measurements
from flightapp.bench.safety import supervisor_measurement
from flightapp.config.mission import load_mission
from flightapp.config.profile import load_profile
from flightapp.core.errors import InputError
from flightapp.runtime.composition import limits_of


def run_bench(mission: Path, profile: Path, seconds: float = 20.0) -> dict[str, object]:
    """Measure for about `seconds` with the obstacles of `mission` and the limits and camera of `profile`.

    Returns the machine and, for each measurement, name, repetitions, wall_ms and cpu_ms (p50, p99, max), aim_ms (of the 99th
    percentile) with its verdict, and how many times faster it is than its plain reference.
    """
    loaded, hardware = load_mission(mission), load_profile(profile)
    vehicle = next((one for one in loaded.vehicles if one.role == "pursuer"), None)
    if vehicle is None:
        raise InputError(f"{mission}: vehicles: no pursuer, so there is no planner to measure")
    before = machine()
    limits = limits_of(vehicle, hardware)
    measurements = [
        *planner_measurements(limits, 0.45 * seconds),
        *camera_measurements(loaded, hardware, vehicle, 0.3 * seconds),
        supervisor_measurement(loaded, hardware, vehicle, limits, 0.1 * seconds),
        recorder_measurement(limits, 0.1 * seconds),
        fleet_measurement(0.05 * seconds),
    ]
    return {"machine": before, "measurements": [_plain(one) for one in measurements]}


def _plain(measurement: Measurement) -> dict[str, object]:
    return {**asdict(measurement), "verdict": measurement.verdict}

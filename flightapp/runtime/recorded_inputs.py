"""What a recording keeps of what the vehicle was started with: enough to build planner and supervisor again."""

from __future__ import annotations

import hashlib
from pathlib import Path

import flightapp
from flightapp.config.mission import Mission, Vehicle
from flightapp.config.parameter_files import names_file
from flightapp.recording.provenance import versions
from flightapp.recording.recorder import Recorder
from flightapp.runtime.composition import strategy_parameters

MISSION_FILE = "mission.toml"
PROFILE_FILE = "profile.toml"
PARAMETERS_FILE = "parameters.toml"
"""The parameter file that the mission names for this vehicle's strategy."""


def strategy_file(parameter: str) -> str:
    """Name of the attached file that the strategy's `parameter` names."""
    return f"strategy-{parameter}"


def record_inputs(
    recorder: Recorder, mission: Mission, vehicle: Vehicle, mission_path: Path, profile_path: Path, seed: int
) -> None:
    """Metadata `run`, and the files as attachments; InputError where one cannot be read."""
    recorder.metadata(
        "run",
        {
            "vehicle": vehicle.name,
            "role": vehicle.role,
            "mission": mission.name,
            "strategy": vehicle.strategy.name,
            "seed": seed,
            "flightapp": flightapp.__version__,
        },
    )
    recorder.metadata("versions", versions())
    recorder.metadata("mission", {"name": mission.name, "sha256": _digest(mission_path)})
    recorder.metadata("profile", {"file": profile_path.name, "sha256": _digest(profile_path)})
    recorder.attach(MISSION_FILE, mission_path)
    recorder.attach(PROFILE_FILE, profile_path)
    if vehicle.strategy.parameters_file is not None:
        recorder.attach(PARAMETERS_FILE, mission_path.parent / vehicle.strategy.parameters_file)
    parameters = strategy_parameters(vehicle, mission_path, str(mission_path))
    recorder.metadata("parameters", parameters)
    for name, value in parameters.items():
        if names_file(name):
            recorder.attach(strategy_file(name), Path(str(value)))


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()

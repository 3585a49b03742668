"""The planner that decides a recorded flight again: the one that flew, or another one."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path

from flightapp.config.loading import read_toml
from flightapp.config.parameter_files import beside, names_file
from flightapp.core.errors import InputError
from flightapp.planning.ac2f.variants import VARIANTS
from flightapp.planning.api import Planner
from flightapp.planning.registry import file_parameters
from flightapp.recording.attachments import attached_tables
from flightapp.replay.flight import Flight
from flightapp.runtime.composition import make_strategy
from flightapp.runtime.recorded_inputs import PARAMETERS_FILE, strategy_file


def strategy_of(flight: Flight, name: str | None = None, parameters: Path | None = None) -> Planner:
    """The planner of `flight`, or the one called `name`; a file of `parameters` counts more than what was flown with.

    What was flown with is kept for another planner only where both have the same parameters.
    """
    strategy = flight.vehicle.strategy
    where = f"{flight.recording.path}: strategy of '{flight.vehicle.name}'"
    wanted = strategy.name if name is None else name
    with tempfile.TemporaryDirectory() as folder:
        given: dict[str, object] = {}
        if wanted == strategy.name or {wanted, strategy.name} <= VARIANTS.keys():
            given = file_parameters(wanted, _flown_with(flight, Path(folder)))
        if parameters is not None:
            given.update(file_parameters(wanted, beside(read_toml(parameters), parameters.parent)))
        return make_strategy(wanted, given, flight.mission, flight.vehicle, flight.profile, where, flight.seed)


def _flown_with(flight: Flight, folder: Path) -> dict[str, object]:
    """Parameters from the attached parameter file, then from the mission, with the attached files in `folder`."""
    strategy = flight.vehicle.strategy
    values: dict[str, object] = {}
    if strategy.parameters_file is not None:
        values.update(file_parameters(strategy.name, attached_tables(flight.recording, PARAMETERS_FILE)))
    values.update(strategy.parameters)
    return {name: _unpacked(flight, name, folder) if names_file(name) else value for name, value in values.items()}


def _unpacked(flight: Flight, parameter: str, folder: Path) -> str:
    attachments: Mapping[str, bytes] = flight.recording.attachments
    name = strategy_file(parameter)
    if name not in attachments:
        raise InputError(f"{flight.recording.path}: the file that the strategy's {parameter} names is not attached")
    path = folder / name
    path.write_bytes(attachments[name])
    return str(path)

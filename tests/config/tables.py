"""The demo mission and the simulation profile as tables to damage, and the sentence that a loader gives back."""

from __future__ import annotations

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import tomli_w

from flightapp.config.loading import read_toml
from flightapp.config.mission import load_mission
from flightapp.config.profile import load_profile
from flightapp.core.errors import InputError

ROOT = Path(__file__).parents[2]
MISSION_PATH = ROOT / "missions" / "demo_two_pursuers.toml"
PROFILE_PATH = ROOT / "profiles" / "sim.toml"
MISSION = read_toml(MISSION_PATH)
PROFILE = read_toml(PROFILE_PATH)

Change = tuple[tuple[str | int, ...], Any]
REMOVED = object()


def changed(tables: dict[str, Any], *changes: Change) -> dict[str, Any]:
    """A copy of `tables` with the value at each path replaced, added or, for REMOVED, taken out."""
    result = copy.deepcopy(tables)
    for path, value in changes:
        place: Any = result
        for part in path[:-1]:
            place = place.setdefault(part, {}) if isinstance(part, str) else place[part]
        if value is REMOVED:
            del place[path[-1]]
        else:
            place[path[-1]] = value
    return result


def refusal(load: Callable[[Path], object], tables: dict[str, Any], folder: Path) -> str:
    """What the loader says about `tables`; empty where it takes them."""
    path = folder / "file.toml"
    path.write_bytes(tomli_w.dumps(tables).encode())
    try:
        load(path)
    except InputError as error:
        return str(error).replace(str(folder) + "/", "")
    return ""


def mission_refusal(folder: Path, *changes: Change) -> str:
    return refusal(load_mission, changed(MISSION, *changes), folder)


def profile_refusal(folder: Path, *changes: Change) -> str:
    return refusal(load_profile, changed(PROFILE, *changes), folder)

"""Does this vehicle, with this profile, fit this mission? Asked before anything is started."""

from __future__ import annotations

from pathlib import Path

from flightapp.config.consistency import check_mission_fits_profile
from flightapp.config.mission import Mission, Vehicle
from flightapp.config.profile import Profile
from flightapp.core.errors import InputError


def check_inputs(mission: Mission, profile: Profile, mission_path: Path, profile_path: Path, name: str) -> Vehicle:
    """The vehicle called `name`; InputError where mission and profile do not fit each other."""
    try:
        vehicle = mission.vehicle(name)
    except KeyError:
        known = ", ".join(vehicle.name for vehicle in mission.vehicles)
        raise InputError(f"{mission_path}: no vehicle is called '{name}'; known: {known}") from None
    check_mission_fits_profile(mission, profile, mission_path, profile_path, name)
    return vehicle

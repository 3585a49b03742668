"""Does this vehicle, with this profile, fit this mission? Asked before anything is started."""

from __future__ import annotations

from pathlib import Path

from flightapp.config.consistency import check_mission_fits_profile
from flightapp.config.mission import Mission, Vehicle
from flightapp.config.profile import Profile


def check_inputs(mission: Mission, profile: Profile, mission_path: Path, profile_path: Path, name: str) -> Vehicle:
    """The vehicle called `name`; InputError where there is none, or where mission and profile contradict each other."""
    check_mission_fits_profile(mission, profile, mission_path, profile_path, name)
    return mission.vehicle(name)

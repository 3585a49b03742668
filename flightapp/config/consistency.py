"""Whether a mission can be flown with a profile: what neither file can check alone."""

from __future__ import annotations

import math
from pathlib import Path

from shapely.geometry import Polygon

from flightapp.config.mission import Mission, Vehicle
from flightapp.config.profile import Profile
from flightapp.core.errors import InputError
from flightapp.safety.braking import horizontal_braking


def check_mission_fits_profile(
    mission: Mission, profile: Profile, mission_path: Path, profile_path: Path, vehicle_name: str
) -> None:
    """InputError lists everything about `vehicle_name` that contradicts the other file, one sentence each."""
    names = [vehicle.name for vehicle in mission.vehicles]
    if vehicle_name not in names:
        raise InputError(f"{mission_path}: vehicles: no vehicle is called '{vehicle_name}'; known: {', '.join(names)}")
    index = names.index(vehicle_name)
    vehicle = mission.vehicles[index]
    findings = [
        _own_speed(vehicle, f"{mission_path}: vehicles[{index}]", profile, profile_path),
        _camera(vehicle, f"{mission_path}: vehicles[{index}]", profile, profile_path),
        _height(mission, vehicle, f"{mission_path}: vehicles[{index}]", profile, profile_path),
        _volume(mission, mission_path, profile, profile_path),
    ]
    if vehicle.role == "pursuer":
        findings += [
            _keep_out(mission, mission_path, profile, profile_path),
            _hold_separation(mission, mission_path, profile, profile_path),
            _start_separation(mission, vehicle, f"{mission_path}: vehicles[{index}]", profile, profile_path),
            _station_separation(mission, vehicle, f"{mission_path}: vehicles[{index}]", profile, profile_path),
        ]
    sentences = [finding for finding in findings if finding]
    if sentences:
        raise InputError("\n".join(sentences))


def _own_speed(vehicle: Vehicle, where: str, profile: Profile, profile_path: Path) -> str:
    limit = profile.limits.speed_max_m_s
    if vehicle.speed_max_m_s is None or vehicle.speed_max_m_s <= limit:
        return ""
    return f"{where}.speed_max_m_s = {vehicle.speed_max_m_s}: must not exceed limits.speed_max_m_s = {limit} in {profile_path}"


def _camera(vehicle: Vehicle, where: str, profile: Profile, profile_path: Path) -> str:
    if not vehicle.camera or profile.camera.source != "none":
        return ""
    return (
        f"{where}.camera = true: camera.source = 'none' in {profile_path}; "
        "must be false for a vehicle that flies on the mission's surveyed obstacles, else the profile must name its camera"
    )


def _height(mission: Mission, vehicle: Vehicle, where: str, profile: Profile, profile_path: Path) -> str:
    margin, volume, height = profile.safety.height_margin_m, mission.flight_volume, mission.height_of(vehicle)
    lowest, highest = volume.height_min_m + margin, volume.height_max_m - margin
    if lowest <= height <= highest:
        return ""
    return (
        f"{where}: flight height {height} m: must lie between {lowest:g} m and {highest:g} m, which is flight_volume's band "
        f"less safety.height_margin_m = {margin} in {profile_path}"
    )


def _volume(mission: Mission, mission_path: Path, profile: Profile, profile_path: Path) -> str:
    limits, safety = profile.limits, profile.safety
    braking = horizontal_braking(limits.as_limits(), safety)
    stop = braking.stop_m(limits.speed_max_m_s)
    needed = stop + safety.fence_margin_m
    if not Polygon(mission.flight_volume.vertices_m).buffer(-needed).is_empty:
        return ""
    return (
        f"{mission_path}: flight_volume.vertices_m = {mission.flight_volume.vertices_m}: too small; from its middle "
        f"{needed:.1f} m to every side must be free, which is the stopping distance {stop:.1f} m from limits.speed_max_m_s = "
        f"{limits.speed_max_m_s} and safety.fence_margin_m = {safety.fence_margin_m} in {profile_path}"
    )


def _keep_out(mission: Mission, mission_path: Path, profile: Profile, profile_path: Path) -> str:
    keep_out, hold = profile.safety.target_keep_out_m, mission.capture.hold_radius_m
    if keep_out < hold or mission.target_contact_allowed:
        return ""
    return (
        f"{profile_path}: safety.target_keep_out_m = {keep_out}: must be smaller than capture.hold_radius_m = {hold} "
        f"in {mission_path}, or no pursuer could reach its holding position"
    )


def _hold_separation(mission: Mission, mission_path: Path, profile: Profile, profile_path: Path) -> str:
    pursuers = sum(vehicle.role == "pursuer" for vehicle in mission.vehicles)
    if pursuers < 2 or not any(vehicle.role == "evader" for vehicle in mission.vehicles):
        return ""
    apart = 2.0 * mission.capture.hold_radius_m * math.sin(math.pi / pursuers)
    safety = profile.safety
    if safety.separation_min_m + safety.separation_buffer_m < apart:
        return ""
    return (
        f"{profile_path}: safety.separation_min_m = {safety.separation_min_m}: with separation_buffer_m = "
        f"{safety.separation_buffer_m} it must be smaller than {apart:.2f} m, the distance between neighbours when "
        f"{pursuers} pursuers hold at capture.hold_radius_m = {mission.capture.hold_radius_m} in {mission_path}"
    )


def _start_separation(mission: Mission, vehicle: Vehicle, where: str, profile: Profile, profile_path: Path) -> str:
    safety = profile.safety
    kept = safety.separation_min_m + safety.separation_buffer_m
    here = (vehicle.start.north_m, vehicle.start.east_m)
    for index, other in enumerate(mission.vehicles):
        if other.name == vehicle.name or other.role != "pursuer":
            continue
        if abs(mission.height_of(other) - mission.height_of(vehicle)) >= safety.separation_height_m:
            continue
        distance = math.dist(here, (other.start.north_m, other.start.east_m))
        if distance < kept:
            return (
                f"{where}.start = {here}: {distance:.2f} m from vehicles[{index}]; must be at least {kept:.2f} m, "
                f"safety.separation_min_m and separation_buffer_m in {profile_path}"
            )
    return ""


def _station_separation(mission: Mission, vehicle: Vehicle, where: str, profile: Profile, profile_path: Path) -> str:
    safety = profile.safety
    kept = safety.separation_min_m + safety.separation_buffer_m
    here = _waiting_place(vehicle)
    for index, other in enumerate(mission.vehicles):
        if other.name == vehicle.name or other.role != "pursuer" or (other.station is None and vehicle.station is None):
            continue
        level = abs(mission.height_of(other) - mission.height_of(vehicle)) < safety.separation_height_m
        distance = math.dist(here, _waiting_place(other))
        if level and distance < kept:
            field = "start" if vehicle.station is None else "station"
            return (
                f"{where}.{field} = {here}: {distance:.2f} m from where vehicles[{index}] waits; must be at least {kept:.2f} m, "
                f"safety.separation_min_m and separation_buffer_m in {profile_path}"
            )
    return ""


def _waiting_place(vehicle: Vehicle) -> tuple[float, float]:
    """(north, east) where it waits for the pursuit."""
    place = vehicle.start if vehicle.station is None else vehicle.station
    return place.north_m, place.east_m

"""Builds one vehicle's rooms from its mission and profile, and takes them down again in the right order."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from flightapp.config.loading import read_toml
from flightapp.config.mission import Mission, Vehicle
from flightapp.config.parameter_files import beside
from flightapp.config.profile import Camera, Profile
from flightapp.config.tracking import Controller
from flightapp.core.clock import SystemClock
from flightapp.core.errors import InputError
from flightapp.core.types import Limits, ObstacleSet
from flightapp.fleet.coordination.team_plan import TeamPlan
from flightapp.planning.api import Planner
from flightapp.planning.registry import (
    evader_names,
    file_parameters,
    known_parameters,
    make_evader,
    make_planner,
    make_team_plan,
    planner_names,
)
from flightapp.recording.depth import DepthCamera
from flightapp.recording.messages import CameraMounting
from flightapp.recording.recorder import Recorder
from flightapp.runtime.depth_recording import DepthRecording, RecordedSource
from flightapp.runtime.perception_thread import PerceptionThread
from flightapp.sim.world import World
from flightapp.vehicle.pose_history import PoseHistory
from perception.errors import PerceptionInputError
from perception.pipeline import PerceptionPipeline
from perception.sources import DepthMode, DepthSource, RealSenseRecordingSource, SharedMemorySource, open_camera

if TYPE_CHECKING:
    from flightapp.control.tracker import VelocityTracker


def limits_of(vehicle: Vehicle, profile: Profile) -> Limits:
    """The profile's limits with the mission's own speed limit for this vehicle."""
    limits = profile.limits.model_dump()
    if vehicle.speed_max_m_s is not None:
        limits["speed_max_m_s"] = min(vehicle.speed_max_m_s, profile.limits.speed_max_m_s)
    return Limits(**limits)


def build_strategy(mission: Mission, vehicle: Vehicle, profile: Profile, mission_path: Path, seed: int) -> Planner:
    """The planner or evader policy that the mission names; parameters from its file, then from the mission itself."""
    where = f"{mission_path}: strategy of '{vehicle.name}'"
    parameters = strategy_parameters(vehicle, mission_path, where)
    return make_strategy(vehicle.strategy.name, parameters, mission, vehicle, profile, where, seed)


def build_team_plan(mission: Mission, vehicle: Vehicle, profile: Profile, mission_path: Path) -> TeamPlan | None:
    """What a pursuer plans by for the team when it leads, where its strategy brings that."""
    if vehicle.role != "pursuer":
        return None
    where = f"{mission_path}: strategy of '{vehicle.name}'"
    given = with_facts(vehicle.strategy.name, strategy_parameters(vehicle, mission_path, where), mission)
    return make_team_plan(vehicle.strategy.name, limits=limits_of(vehicle, profile), parameters=given)


def strategy_parameters(vehicle: Vehicle, mission_path: Path, where: str) -> dict[str, object]:
    """What mission and parameter file say of the vehicle's strategy; paths as they are reached from here."""
    parameters: dict[str, object] = {}
    strategy = vehicle.strategy
    if strategy.parameters_file is not None:
        file = mission_path.parent / strategy.parameters_file
        try:
            parameters.update(file_parameters(strategy.name, beside(read_toml(file), file.parent)))
        except InputError as error:
            raise InputError(f"{where}: parameters_file: {error}") from None
    parameters.update(beside(strategy.parameters, mission_path.parent))
    return parameters


def make_strategy(
    name: str,
    parameters: Mapping[str, object],
    mission: Mission,
    vehicle: Vehicle,
    profile: Profile,
    where: str,
    seed: int,
) -> Planner:
    """The planner or evader policy `name` for `vehicle`; what `parameters` leave open is the mission's. `where` begins errors."""
    limits = limits_of(vehicle, profile)
    if vehicle.role == "evader":
        if name not in evader_names():
            raise InputError(f"{where}: name = '{name}': no such evader policy; known: {', '.join(evader_names())}")
        return _named(where, lambda: make_evader(name, limits=limits, parameters=parameters, seed=seed))
    if name not in planner_names():
        raise InputError(f"{where}: name = '{name}': no such planner; known: {', '.join(planner_names())}")
    given = with_facts(name, parameters, mission)
    return _named(where, lambda: make_planner(name, limits=limits, parameters=given, seed=seed))


def build_tracker(mission: Mission, vehicle: Vehicle, profile: Profile) -> VelocityTracker | None:
    """What follows the decided velocity over the autopilot's own loop; None where that loop is alone."""
    if vehicle.role != "pursuer" or controller_of(mission, profile) == "autopilot":
        return None
    from flightapp.control.tracker import make_tracker

    return make_tracker(profile)


def controller_of(mission: Mission, profile: Profile) -> Controller:
    """The mission's word goes before the profile's."""
    return profile.control.controller if mission.controller is None else mission.controller


def feeds_forward(mission: Mission, profile: Profile) -> bool:
    """Whether accelerations are sent beside velocities."""
    return profile.control.acceleration_feed_forward or controller_of(mission, profile) != "autopilot"


def with_facts(name: str, parameters: Mapping[str, object], mission: Mission) -> dict[str, object]:
    """A pursuer's `parameters`; of what they leave open, the strategy `name` is told those facts of the mission that it takes."""
    facts = {"capture": mission.capture.model_dump(), "evader_speed_assumed_m_s": mission.evader_speed_assumed_m_s}
    known = known_parameters(name)
    return {**{fact: value for fact, value in facts.items() if known is None or fact in known}, **parameters}


def surveyed_obstacles(mission: Mission) -> ObstacleSet:
    """The mission's obstacles as discs, for a vehicle that flies without a camera."""
    return ObstacleSet(0.0, World(mission.obstacles).as_discs(), np.zeros((0, 2)))


def build_perception(
    vehicle: Vehicle,
    profile: Profile,
    clock: SystemClock,
    history: PoseHistory,
    on_result: Callable[[], None],
    recorder: Recorder,
) -> PerceptionThread:
    """The camera and its thread, its frames recorded if the profile says so; InputError where the camera cannot be opened."""
    camera = profile.camera
    pipeline = PerceptionPipeline(
        profile.perception,
        camera.mounting,
        range_min_m=camera.range_min_m,
        range_max_m=camera.range_max_m,
        ground_down_m=-vehicle.start.ground_height_m,
    )
    source = _open_camera(camera, clock)
    if profile.recording.depth_rate_hz > 0.0:
        source = RecordedSource(source, DepthRecording(recorder, history, _depth_camera(vehicle, camera), profile.recording))
    return PerceptionThread(source, pipeline, history, clock, on_result, 1.0 / profile.autopilot.telemetry_rate_hz)


def _depth_camera(vehicle: Vehicle, camera: Camera) -> DepthCamera:
    return DepthCamera(
        CameraMounting(**camera.mounting.model_dump()),
        camera.range_min_m,
        camera.range_max_m,
        -vehicle.start.ground_height_m,
    )


def _open_camera(camera: Camera, clock: SystemClock) -> DepthSource:
    try:
        if camera.source == "realsense":
            return open_camera(
                now_s=clock.now_s,
                unix_s=clock.unix_s,
                mode=DepthMode(camera.width_px, camera.height_px, camera.rate_hz),
                serial_number=camera.serial_number,
                stall_timeout_s=camera.stall_timeout_s,
                emitter=camera.emitter,
            )
        assert camera.path is not None
        if camera.source == "realsense-recording":
            return RealSenseRecordingSource(camera.path, now_s=clock.now_s, is_real_time=True)
        return SharedMemorySource(camera.path, clock.from_monotonic_ns)
    except PerceptionInputError as error:
        raise InputError(f"camera.source = '{camera.source}': {error}") from None


def _named(where: str, build: Callable[[], Planner]) -> Planner:
    try:
        return build()
    except InputError as error:
        raise InputError(f"{where}: {error}") from None

"""Opens the rooms of one vehicle in the right order, runs its control loop, and closes everything again."""

from __future__ import annotations

import asyncio
import gc
import hashlib
from collections.abc import AsyncIterator, Callable
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from flightapp.config.mission import Mission, load_mission
from flightapp.config.profile import RecordingOptions, load_profile
from flightapp.core.clock import SystemClock
from flightapp.core.errors import FlightError
from flightapp.estimation.target_filter import TargetFilter
from flightapp.fleet.messages.command import Command
from flightapp.fleet.security.access import membership_of
from flightapp.fleet.session import open_session
from flightapp.fleet.team import Team
from flightapp.recording.live import LiveView, url_told
from flightapp.recording.recorder import Recorder
from flightapp.recording.small_log import SUFFIX
from flightapp.runtime.composition import (
    build_perception,
    build_strategy,
    build_team_plan,
    build_tracker,
    feeds_forward,
    limits_of,
    surveyed_obstacles,
)
from flightapp.runtime.control_loop import ControlLoop
from flightapp.runtime.heartbeat import Heartbeat
from flightapp.runtime.inputs import check_inputs
from flightapp.runtime.journal import Journal
from flightapp.runtime.leadership import memory_path
from flightapp.runtime.outcome import Outcome
from flightapp.runtime.recorded_inputs import record_inputs
from flightapp.runtime.rooms import Rooms
from flightapp.runtime.velocity_loop import learn_velocity_gains
from flightapp.safety.supervisor import make_supervisor
from flightapp.vehicle.pose_history import PoseHistory
from flightapp.vehicle.px4 import Px4


@dataclass(frozen=True, slots=True)
class Wish:
    """Which vehicle, with what, and where its recording goes."""

    mission: Path
    profile: Path
    vehicle: str
    run: Path
    seed: int
    live: LiveView | None = None
    """Where to serve the live view."""


@dataclass(frozen=True, slots=True)
class Opened:
    """The rooms, and what only perception needs besides."""

    rooms: Rooms
    clock: SystemClock
    history: PoseHistory
    recorder: Recorder


@asynccontextmanager
async def open_rooms(wish: Wish, heartbeat: Heartbeat) -> AsyncIterator[Opened]:
    """Everything that can be refused is refused before the autopilot is touched; then it is connected."""
    mission, profile = load_mission(wish.mission), load_profile(wish.profile)
    vehicle = check_inputs(mission, profile, wish.mission, wish.profile, wish.vehicle)
    clock = SystemClock()
    planner = build_strategy(mission, vehicle, profile, wish.mission, wish.seed)
    supervisor = make_supervisor(mission, profile, wish.vehicle)
    network = profile.network
    membership = membership_of(mission, network.certificates, access_control=network.access_control)
    async with AsyncExitStack() as stack:
        recorder = stack.enter_context(_recorder(wish, profile.recording, mission))
        record_inputs(recorder, mission, vehicle, wish.mission, wish.profile, wish.seed)
        journal = Journal(recorder, clock, wish.vehicle)
        session = await open_session(network.listen_endpoints, network.connect_endpoints, membership=membership)
        stack.callback(session.close)
        others = [other.name for other in mission.vehicles if other.name != wish.vehicle]
        team = Team(
            session,
            mission.fleet,
            wish.vehicle,
            others,
            lambda peer, text: journal.event("warning", "network", text, peer=peer),
        )
        history = PoseHistory()
        autopilot = Px4(
            profile.autopilot,
            vehicle.system_id,
            mission.datum.as_point(),
            clock,
            history,
            acceleration_feed_forward=feeds_forward(mission, profile),
        )
        stack.callback(autopilot.close)
        rooms = Rooms(
            clock=clock,
            mission=mission,
            mission_digest=hashlib.sha256(wish.mission.read_bytes()).hexdigest()[:12],
            vehicle=vehicle,
            profile=profile,
            limits=limits_of(vehicle, profile),
            autopilot=autopilot,
            planner=planner,
            supervisor=supervisor,
            target_filter=TargetFilter(),
            team=team,
            journal=journal,
            heartbeat=heartbeat,
            boundary=mission.boundary.as_boundary(),
            surveyed=surveyed_obstacles(mission),
            election_memory=memory_path(wish.run, profile.recording.folder, mission.fleet, wish.vehicle),
            team_plan=build_team_plan(mission, vehicle, profile, wish.mission),
            tracker=build_tracker(mission, vehicle, profile),
        )
        journal.event("info", "recording", str(recorder.path))
        if recorder.live_url is not None:
            journal.event("info", "live", f"live view: {recorder.live_url}", url=recorder.live_url)
            stack.enter_context(url_told(wish.run, wish.vehicle, recorder.live_url))
        try:
            journal.event("info", "autopilot", await autopilot.connect())
            await learn_velocity_gains(rooms)
        except FlightError as error:
            journal.event("error", "fault", str(error))
            journal.phase("done", str(error), Outcome.FAULT.value)
            raise
        yield Opened(rooms, clock, history, recorder)


def _recorder(wish: Wish, options: RecordingOptions, mission: Mission) -> Recorder:
    small_path = wish.run / f"{wish.vehicle}{SUFFIX}" if options.small_log else None
    path = wish.run / f"{wish.vehicle}.mcap"
    return Recorder(path, options=options, mission=mission, small_path=small_path, live=wish.live)


@asynccontextmanager
async def running_loop(opened: Opened, on_command: Callable[[Command], tuple[bool, str]]) -> AsyncIterator[ControlLoop]:
    """The control loop, and perception where the vehicle has a camera, while the context lasts."""
    rooms = opened.rooms
    loop = ControlLoop(rooms, on_command)
    async with AsyncExitStack() as stack:
        if rooms.vehicle.camera and rooms.profile.camera.source != "none":
            loop.perception = build_perception(
                rooms.vehicle, rooms.profile, opened.clock, opened.history, loop.wake_from_thread, opened.recorder
            )
            stack.callback(loop.perception.stop)
            loop.perception.start()
        gc.collect()
        gc.freeze()
        task = asyncio.create_task(loop.run(), name="control loop")
        try:
            yield loop
        finally:
            await _publish_the_end(loop)
            task.cancel()
            with suppress(asyncio.CancelledError):
                await task
            rooms.autopilot.close()  # The deadman watches until MAVSDK, and with it its repeats, is gone.
            rooms.heartbeat.beat(loop.last_stage)


async def _publish_the_end(loop: ControlLoop) -> None:
    """A few more ticks, so that the others hear the last state."""
    ticks = loop.ticks
    with suppress(TimeoutError):
        async with asyncio.timeout(1.0):
            while loop.ticks < ticks + 5:
                await asyncio.sleep(0.02)

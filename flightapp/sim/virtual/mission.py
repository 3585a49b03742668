"""A whole mission on the virtual clock: every vehicle's own rooms, control loop and executive, in one process.

What is real: mission, profile, planner, supervisor, failsafes, executive, control loop, team, target filter, recorder, and the
mock autopilot with its physics and MAVLink. What is replaced: MAVSDK, Zenoh, depth pictures, the deadman, and time.
"""

from __future__ import annotations

import asyncio
import hashlib
import math
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

from flightapp.config.mission import Mission, Vehicle, load_mission
from flightapp.config.profile import Profile, load_profile
from flightapp.core.errors import FlightError
from flightapp.estimation.target_filter import TargetFilter
from flightapp.fleet.team import Team
from flightapp.planning.api import Planner
from flightapp.recording.recorder import Recorder
from flightapp.recording.sink import OpenFile, create_file
from flightapp.runtime.composition import build_strategy, build_team_plan, build_tracker, limits_of, surveyed_obstacles
from flightapp.runtime.control_loop import ControlLoop
from flightapp.runtime.executive import Executive
from flightapp.runtime.heartbeat import CLIMBING, IDLE, LEFT, Heartbeat
from flightapp.runtime.journal import Journal
from flightapp.runtime.leadership import memory_path
from flightapp.runtime.outcome import Outcome
from flightapp.runtime.perception_thread import PerceptionThread
from flightapp.runtime.recorded_inputs import record_inputs
from flightapp.runtime.rooms import Rooms
from flightapp.runtime.velocity_loop import learn_velocity_gains
from flightapp.safety.supervisor import make_supervisor
from flightapp.sim.autopilot_frames import Frames, displaced_origin
from flightapp.sim.autopilot_parameters import Value
from flightapp.sim.fault_script import FaultScript
from flightapp.sim.mavlink_dialect import mavlink
from flightapp.sim.mission_wind import wind_of
from flightapp.sim.mock_autopilot import Setup, frame_limits, make_station, with_velocity_loop
from flightapp.sim.virtual.autopilot import VirtualAutopilot
from flightapp.sim.virtual.camera import VirtualCamera
from flightapp.sim.virtual.event_loop import VirtualClock, VirtualEventLoop
from flightapp.sim.virtual.fleet import VirtualFleet, VirtualVehicle, Watch
from flightapp.sim.virtual.network import VirtualNetwork
from flightapp.sim.virtual.rendered_camera import RenderedSource, perception_of
from flightapp.vehicle.last_resort import COMPANION, TIMEOUT_S, Advice, advice
from flightapp.vehicle.pose_history import PoseHistory

PARAMETERS: dict[str, Value] = {"COM_OBL_RC_ACT": 4, "COM_RC_OVERRIDE": 3, "COM_LOW_BAT_ACT": 3}
DEADMAN_CHECK_S = 0.05
HEARTBEAT_S = 1.0
RECORDER_WAITING_MAX = 1 << 20
"""The recorder's thread lives in real time, which the mission outruns: nothing is dropped for that."""
RECORDER_CLOSE_S = 600.0
"""On a busy machine it may be far behind."""
TIME_LIMIT_S = 900.0


def fly_virtual(
    mission_path: Path,
    profile_path: Path,
    run: Path,
    *,
    seed: int = 0,
    faults: dict[str, FaultScript] | None = None,
    watch: Watch | None = None,
    strategies: dict[str, Planner] | None = None,
    change_profile: Callable[[Profile], Profile] | None = None,
    time_limit_s: float = TIME_LIMIT_S,
    rendered: bool = False,
    flown: Collection[str] | None = None,
    clock_ahead_s: Mapping[str, float] | None = None,
    open_file: OpenFile = create_file,
) -> VirtualFleet:
    """Fly `mission_path` to its end. Recordings go to `run`, which must exist. Ctrl-C breaks it off, and recordings with it.

    faults: script of each vehicle's autopilot. watch: called after every step. strategies: planners in place of the mission's.
    rendered: obstacles come from depth pictures through perception, not from the mission.
    flown: only these vehicles; the others' states are for `watch` to publish.
    open_file: the recorders' disk. clock_ahead_s: of vehicles' computers.
    """
    mission, profile = load_mission(mission_path), load_profile(profile_path)
    profile = profile if change_profile is None else change_profile(profile)
    event_loop = VirtualEventLoop()

    async def fly() -> VirtualFleet:
        fleet = VirtualFleet(mission, event_loop, watch)
        network = fleet.network
        builder = _Builder(mission, mission_path, profile_path, profile, run, seed, event_loop, network, open_file, rendered)
        for index, vehicle in enumerate(mission.vehicles):
            if flown is None or vehicle.name in flown:
                script = (faults or {}).get(vehicle.name, FaultScript())
                one = builder.build(index, vehicle, script, (strategies or {}).get(vehicle.name))
                one.clock.offset_s = (clock_ahead_s or {}).get(vehicle.name, 0.0)
                fleet.vehicles[vehicle.name] = one
        await _until_over(fleet, time_limit_s)
        return fleet

    flying = event_loop.create_task(fly())
    try:
        return event_loop.run_until_complete(flying)
    except KeyboardInterrupt:
        flying.cancel()  # else its tasks would end on a closed loop, each with a complaint, and the recorders never
        with suppress(asyncio.CancelledError):
            event_loop.run_until_complete(flying)
        raise
    finally:
        event_loop.close()


async def _until_over(fleet: VirtualFleet, time_limit_s: float) -> None:
    """Fly until everybody is down, or the fleet is stopped; an exception of the watch ends it too."""
    physics = asyncio.create_task(fleet.run_physics())
    flights = [asyncio.create_task(_flight(one)) for one in fleet.vehicles.values()]
    ends = [asyncio.create_task(_until_down(fleet, flights)), asyncio.create_task(fleet.until_stopped())]
    tasks = [physics, *flights, *ends]
    is_broken_off = False
    try:
        done, _ = await asyncio.wait((physics, *ends), timeout=time_limit_s, return_when=asyncio.FIRST_COMPLETED)
        for task in done:
            await task
        if not done:
            for one in fleet.vehicles.values():
                one.error = one.error or f"not over after {time_limit_s:g} s"
    except (asyncio.CancelledError, KeyboardInterrupt):
        is_broken_off = True
        raise
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        for one in fleet.vehicles.values():
            if is_broken_off:
                one.recorder.abandon()
            else:
                one.recorder.close(RECORDER_CLOSE_S)


async def _until_down(fleet: VirtualFleet, flights: list[asyncio.Task[None]]) -> None:
    await asyncio.gather(*flights)
    while any(one.station.core.armed for one in fleet.vehicles.values()):
        await asyncio.sleep(0.1)


async def _flight(one: VirtualVehicle) -> None:
    """What the vehicle process does, with the deadman beside it."""
    beating = _Beating(one)
    one.tasks = [
        asyncio.create_task(one.loop.run()),
        asyncio.create_task(_mission(one)),
        asyncio.create_task(beating.watch()),
    ]
    try:
        await asyncio.wait(one.tasks[1:], return_when=asyncio.FIRST_COMPLETED)
        if one.hung:
            await asyncio.wait(one.tasks[2:])
        elif one.tasks[1].done() and not one.tasks[1].cancelled():  # The process ends by itself, as `opening.running_loop` does.
            one.rooms.heartbeat.beat(one.loop.last_stage)
    finally:
        for task in one.tasks:
            task.cancel()
        await asyncio.gather(*one.tasks, return_exceptions=True)
        one.autopilot.close()
    if one.rooms.heartbeat.last in (CLIMBING, LEFT):
        await _last_resort(one)


async def _last_resort(one: VirtualVehicle) -> None:
    """What `vehicle.last_resort` does over the link that the process has left, once for every heartbeat that is heard."""
    packer = mavlink.MAVLink(None, srcSystem=one.rooms.vehicle.system_id, srcComponent=COMPANION)
    land = mavlink.MAVLink_command_long_message(one.rooms.vehicle.system_id, 1, mavlink.MAV_CMD_NAV_LAND, 0, *(0.0,) * 7)
    core = one.station.core
    heard_s = one.rooms.clock.now_s()
    end_s = heard_s + TIMEOUT_S
    while one.rooms.clock.now_s() < end_s:
        await asyncio.sleep(HEARTBEAT_S)
        if one.autopilot.status().heartbeat_s <= heard_s:
            continue
        heard_s = one.autopilot.status().heartbeat_s
        if advice(mavlink.MAV_MODE_FLAG_SAFETY_ARMED if core.armed else 0, core.mode.custom_mode) is not Advice.LAND:
            return
        one.station.receive(land.pack(packer))


async def _mission(one: VirtualVehicle) -> None:
    try:
        await one.autopilot.connect()
        await learn_velocity_gains(one.rooms)
        one.outcome = await one.executive.fly()
        ticks = one.loop.ticks
        with suppress(TimeoutError):
            async with asyncio.timeout(1.0):
                while one.loop.ticks < ticks + 5:
                    await asyncio.sleep(0.02)
    except FlightError as error:
        one.outcome, one.error = Outcome.FAULT, str(error)


class _Beating:
    """The deadman: kills a vehicle whose control loop has been silent for too long while setpoints may flow."""

    def __init__(self, one: VirtualVehicle) -> None:
        self._one = one
        self._ticks = -1
        self._since_s = one.rooms.clock.now_s()

    async def watch(self) -> None:
        timeout_s = self._one.rooms.profile.control.deadman_timeout_s
        while True:
            await asyncio.sleep(DEADMAN_CHECK_S)
            now_s = self._one.rooms.clock.now_s()
            if self._one.loop.ticks != self._ticks:
                self._ticks, self._since_s = self._one.loop.ticks, now_s
            elif now_s - self._since_s > timeout_s and self._one.rooms.heartbeat.last != IDLE:
                self._one.error = f"deadman: control loop silent for {now_s - self._since_s:.2f} s"
                self._one.outcome = Outcome.FAULT
                return


@dataclass(slots=True)
class _Builder:
    """From mission and profile to the vehicles of a virtual fleet."""

    mission: Mission
    mission_path: Path
    profile_path: Path
    profile: Profile
    run: Path
    seed: int
    event_loop: VirtualEventLoop
    network: VirtualNetwork
    open_file: OpenFile
    rendered: bool

    def build(self, index: int, vehicle: Vehicle, script: FaultScript, strategy: Planner | None) -> VirtualVehicle:
        mission, profile, clock, name = self.mission, self.profile, VirtualClock(self.event_loop), vehicle.name
        datum, simulation, start = mission.datum.as_point(), mission.simulation, vehicle.start
        events: list[dict[str, object]] = []
        setup = Setup(
            system_id=vehicle.system_id,
            frames=Frames(datum, displaced_origin(datum, simulation.origin_offset_m, index)),
            position_ned_m=(start.north_m, start.east_m, -start.ground_height_m),
            heading_rad=math.radians(start.heading_deg),
            limits=with_velocity_loop(frame_limits(profile.limits), simulation.velocity_loop),
            wind=wind_of(simulation, self.seed),
            script=script,
            parameters=dict(PARAMETERS),
            noise=None,
            seed=self.seed * 1000 + vehicle.system_id,
        )
        station, faults = make_station(replace(setup), events.append)
        history = PoseHistory()
        autopilot = VirtualAutopilot(station, vehicle.system_id, datum, clock, history)
        recorder = Recorder(
            self.run / f"{name}.mcap",
            options=profile.recording,
            mission=mission,
            buffer_messages=RECORDER_WAITING_MAX,
            open_file=self.open_file,
        )
        recorder.open()
        record_inputs(recorder, mission, vehicle, self.mission_path, self.profile_path, self.seed)
        journal = Journal(recorder, clock, name)
        others = [other.name for other in mission.vehicles if other.name != name]

        def complain(peer: str, text: str) -> None:
            journal.event("warning", "network", text, peer=peer)

        rooms = Rooms(
            clock=clock,
            mission=mission,
            mission_digest=hashlib.sha256(self.mission_path.read_bytes()).hexdigest()[:12],
            vehicle=vehicle,
            profile=profile,
            limits=limits_of(vehicle, profile),
            autopilot=autopilot,
            planner=strategy or build_strategy(mission, vehicle, profile, self.mission_path, self.seed),
            supervisor=make_supervisor(mission, profile, name),
            target_filter=TargetFilter(),
            team=Team(self.network.session(name), mission.fleet, name, others, complain),
            journal=journal,
            heartbeat=Heartbeat(None),
            boundary=mission.boundary.as_boundary(),
            surveyed=surveyed_obstacles(mission),
            election_memory=memory_path(self.run, profile.recording.folder, mission.fleet, name),
            team_plan=build_team_plan(mission, vehicle, profile, self.mission_path),
            tracker=build_tracker(mission, vehicle, profile),
        )
        executive = Executive(rooms)
        loop = ControlLoop(rooms, executive.on_command)
        executive.attach(loop)
        camera, source = None, None
        if vehicle.camera and profile.camera.source != "none":
            if self.rendered:
                source = RenderedSource(mission, profile, clock, self.seed * 1000 + vehicle.system_id)
                loop.perception = perception_of(source, vehicle, profile, history, clock, loop.wake_from_thread)
            else:
                camera = VirtualCamera(rooms.surveyed.discs, profile.camera.range_max_m, history, clock)
                loop.perception = cast(PerceptionThread, camera)
        return VirtualVehicle(
            vehicle, clock, station, faults, autopilot, camera, source, rooms, recorder, executive, loop, events
        )

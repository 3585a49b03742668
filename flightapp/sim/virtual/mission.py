"""A whole mission on the virtual clock: every vehicle's own rooms, control loop and executive, in one process.

What is real: mission, profile, planner, supervisor, failsafes, executive, control loop, team, target filter, recorder, and the
mock autopilot with its physics and MAVLink. What is replaced: MAVSDK, Zenoh, depth pictures, the deadman, and time.
"""

from __future__ import annotations

import asyncio
import hashlib
import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from flightapp.config.mission import Mission, Vehicle, load_mission
from flightapp.config.profile import Profile, load_profile
from flightapp.core.errors import FlightError
from flightapp.core.types import Array
from flightapp.estimation.target_filter import TargetFilter
from flightapp.fleet.team import Team
from flightapp.planning.api import Planner
from flightapp.recording.recorder import Recorder
from flightapp.runtime.composition import build_strategy, limits_of, surveyed_obstacles
from flightapp.runtime.control_loop import ControlLoop
from flightapp.runtime.executive import Executive
from flightapp.runtime.heartbeat import Heartbeat
from flightapp.runtime.journal import Journal
from flightapp.runtime.outcome import Outcome
from flightapp.runtime.perception_thread import PerceptionThread
from flightapp.runtime.rooms import Rooms
from flightapp.safety.supervisor import make_supervisor
from flightapp.sim.autopilot_core import STEP_S
from flightapp.sim.autopilot_frames import Frames, displaced_origin
from flightapp.sim.autopilot_parameters import Value
from flightapp.sim.fault_script import FaultEngine, FaultScript
from flightapp.sim.mavlink_io import Station
from flightapp.sim.mock_autopilot import Setup, frame_limits, make_station
from flightapp.sim.multirotor import Wind
from flightapp.sim.virtual.autopilot import VirtualAutopilot
from flightapp.sim.virtual.camera import VirtualCamera
from flightapp.sim.virtual.event_loop import VirtualClock, VirtualEventLoop
from flightapp.sim.virtual.network import VirtualNetwork
from flightapp.sim.virtual.rendered_camera import RenderedSource, perception_of
from flightapp.sim.world import World
from flightapp.vehicle.pose_history import PoseHistory

PARAMETERS: dict[str, Value] = {"COM_OBL_RC_ACT": 4, "COM_RC_OVERRIDE": 3, "COM_LOW_BAT_ACT": 3}
DEADMAN_CHECK_S = 0.05
TIME_LIMIT_S = 900.0


@dataclass(slots=True)
class VirtualVehicle:
    """One vehicle with everything that a test or a fault may want to touch."""

    vehicle: Vehicle
    station: Station
    faults: FaultEngine
    autopilot: VirtualAutopilot
    camera: VirtualCamera | None
    rendered: RenderedSource | None
    """The source of real depth pictures, where these are flown by instead of `camera`."""
    rooms: Rooms
    recorder: Recorder
    executive: Executive
    loop: ControlLoop
    events: list[dict[str, object]]
    tasks: list[asyncio.Task[Any]] = field(default_factory=list)
    outcome: Outcome | None = None
    error: str = ""
    hung: bool = False
    """The interpreter hangs: no tick, MAVSDK repeats, until the deadman acts."""

    @property
    def name(self) -> str:
        return self.vehicle.name

    @property
    def position_ned_m(self) -> Array:
        """True position."""
        return np.array(self.station.core.vehicle.position_ned_m)

    @property
    def velocity_ned_m_s(self) -> Array:
        return np.array(self.station.core.vehicle.velocity_ned_m_s)

    @property
    def is_flying(self) -> bool:
        return self.station.core.armed and not self.station.core.vehicle.on_ground

    def kill(self) -> None:
        """SIGKILL of the vehicle process: tasks end without any last word, repeats end with them."""
        for task in self.tasks:
            task.cancel()
        self.autopilot.silence()


@dataclass(slots=True)
class VirtualFleet:
    """All vehicles of one mission. `after_step` is called every STEP_S of virtual time: observe, break, judge."""

    mission: Mission
    clock: VirtualClock
    network: VirtualNetwork
    vehicles: dict[str, VirtualVehicle]
    world: World


Watch = Callable[[VirtualFleet], None]


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
) -> VirtualFleet:
    """Fly `mission_path` to its end. Recordings go to `run`, which must exist.

    rendered: obstacles come from depth pictures through perception, not from the mission.
    faults: script of each vehicle's autopilot. watch: called after every step. strategies: planners in place of the mission's.
    """
    loop = VirtualEventLoop()
    try:
        return loop.run_until_complete(
            _fly(
                loop,
                mission_path,
                profile_path,
                run,
                seed,
                faults or {},
                watch,
                strategies or {},
                change_profile,
                time_limit_s,
                rendered,
            )
        )
    finally:
        loop.close()


async def _fly(
    event_loop: VirtualEventLoop,
    mission_path: Path,
    profile_path: Path,
    run: Path,
    seed: int,
    faults: dict[str, FaultScript],
    watch: Watch | None,
    strategies: dict[str, Planner],
    change_profile: Callable[[Profile], Profile] | None,
    time_limit_s: float,
    rendered: bool,
) -> VirtualFleet:
    mission, profile = load_mission(mission_path), load_profile(profile_path)
    profile = profile if change_profile is None else change_profile(profile)
    clock = VirtualClock(event_loop)
    network = VirtualNetwork(event_loop.call_later)
    builder = _Builder(mission, mission_path, profile, run, seed, clock, network, rendered)
    fleet = VirtualFleet(mission, clock, network, {}, World(mission.obstacles))
    for index, vehicle in enumerate(mission.vehicles):
        script = faults.get(vehicle.name, FaultScript())
        fleet.vehicles[vehicle.name] = builder.build(index, vehicle, script, strategies.get(vehicle.name))
    physics = asyncio.create_task(_physics(fleet, watch))
    flights = [asyncio.create_task(_flight(one)) for one in fleet.vehicles.values()]
    try:
        async with asyncio.timeout(time_limit_s):
            await asyncio.gather(*flights)
            while any(one.is_flying for one in fleet.vehicles.values()):
                await asyncio.sleep(0.1)
    except TimeoutError:
        for one in fleet.vehicles.values():
            one.error = one.error or f"not over after {time_limit_s:g} s"
    finally:
        for task in (physics, *flights):
            task.cancel()
        await asyncio.gather(physics, *flights, return_exceptions=True)
        for one in fleet.vehicles.values():
            one.recorder.close()
    return fleet


async def _physics(fleet: VirtualFleet, watch: Watch | None) -> None:
    """Everything outside the vehicle processes: the autopilots, the cameras' pictures, the deadmen."""
    steps = 0
    camera_steps = {one.name: round(1.0 / (one.rooms.profile.camera.rate_hz * STEP_S)) for one in fleet.vehicles.values()}
    while True:
        for one in fleet.vehicles.values():
            one.autopilot.repeat()
            for packet in one.station.step():
                one.autopilot.receive(packet)
            _see(fleet, one, picture_due=steps % camera_steps[one.name] == 0)
        if watch is not None:
            watch(fleet)
        steps += 1
        await asyncio.sleep(STEP_S)


def _see(fleet: VirtualFleet, one: VirtualVehicle, *, picture_due: bool) -> None:
    """The camera of one vehicle, and its perception thread where there are real pictures."""
    if one.camera is not None and picture_due and one.camera.shoot() and not one.hung:
        one.loop.wake_from_thread()
    if one.rendered is not None and one.loop.perception is not None:
        if picture_due:
            one.rendered.shoot(one.station.core, [other.station.core for other in fleet.vehicles.values() if other is not one])
        if not one.hung:
            one.loop.perception.step()


async def _flight(one: VirtualVehicle) -> None:
    """What the vehicle process does, with the deadman beside it."""
    beating = _Beating(one)
    one.tasks = [
        asyncio.create_task(one.loop.run()),
        asyncio.create_task(_mission(one)),
        asyncio.create_task(beating.watch()),
    ]
    await asyncio.wait(one.tasks[1:], return_when=asyncio.FIRST_COMPLETED)
    for task in one.tasks:
        task.cancel()
    await asyncio.gather(*one.tasks, return_exceptions=True)
    one.autopilot.close()


async def _mission(one: VirtualVehicle) -> None:
    try:
        await one.autopilot.connect()
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
            elif now_s - self._since_s > timeout_s and self._one.autopilot.status().armed:
                self._one.error = f"deadman: control loop silent for {now_s - self._since_s:.2f} s"
                self._one.outcome = Outcome.FAULT
                return


@dataclass(slots=True)
class _Builder:
    """From mission and profile to the vehicles of a virtual fleet."""

    mission: Mission
    mission_path: Path
    profile: Profile
    run: Path
    seed: int
    clock: VirtualClock
    network: VirtualNetwork
    rendered: bool

    def build(self, index: int, vehicle: Vehicle, script: FaultScript, strategy: Planner | None) -> VirtualVehicle:
        mission, profile, clock, name = self.mission, self.profile, self.clock, vehicle.name
        datum, simulation, start = mission.datum.as_point(), mission.simulation, vehicle.start
        events: list[dict[str, object]] = []
        setup = Setup(
            system_id=vehicle.system_id,
            frames=Frames(datum, displaced_origin(datum, simulation.origin_offset_m, index)),
            position_ned_m=(start.north_m, start.east_m, -start.ground_height_m),
            heading_rad=math.radians(start.heading_deg),
            limits=frame_limits(profile.limits),
            wind=Wind(simulation.wind_north_m_s, simulation.wind_east_m_s, simulation.gust_m_s),
            script=script,
            parameters=dict(PARAMETERS),
            noise=None,
            seed=self.seed * 1000 + vehicle.system_id,
        )
        station, faults = make_station(replace(setup), events.append)
        history = PoseHistory()
        autopilot = VirtualAutopilot(station, vehicle.system_id, datum, clock, history)
        recorder = Recorder(self.run / f"{name}.mcap", options=profile.recording, mission=mission)
        recorder.open()
        recorder.metadata("run", {"vehicle": name, "role": vehicle.role, "mission": mission.name, "seed": self.seed})
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
        return VirtualVehicle(vehicle, station, faults, autopilot, camera, source, rooms, recorder, executive, loop, events)

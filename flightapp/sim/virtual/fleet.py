"""The vehicles of a mission on the virtual clock, everything around them that moves by itself, and what a fault may touch."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from flightapp.config.mission import Mission, Vehicle
from flightapp.core.types import Array
from flightapp.recording.recorder import Recorder
from flightapp.runtime.control_loop import ControlLoop
from flightapp.runtime.executive import Executive
from flightapp.runtime.outcome import Outcome
from flightapp.runtime.rooms import Rooms
from flightapp.sim.autopilot_core import STEP_S
from flightapp.sim.fault_script import FaultEngine
from flightapp.sim.mavlink_io import Station
from flightapp.sim.virtual.autopilot import VirtualAutopilot
from flightapp.sim.virtual.camera import VirtualCamera
from flightapp.sim.virtual.event_loop import VirtualClock, VirtualEventLoop
from flightapp.sim.virtual.network import VirtualNetwork
from flightapp.sim.virtual.rendered_camera import RenderedSource
from flightapp.sim.world import World


@dataclass(slots=True)
class VirtualVehicle:
    """One vehicle with everything that a test or a fault may want to touch."""

    vehicle: Vehicle
    clock: VirtualClock
    """Its own computer's."""
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
    """See `hang`."""

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

    def hang(self) -> None:
        """The interpreter hangs: neither tick nor mission go on, MAVSDK repeats, until the deadman acts."""
        self.hung = True
        for task in self.tasks[:2]:
            task.cancel()


class VirtualFleet:
    """The vehicles of one mission that are flown, and everything around them."""

    def __init__(self, mission: Mission, event_loop: VirtualEventLoop, watch: Watch | None) -> None:
        self.mission = mission
        self.clock = VirtualClock(event_loop)
        self.network = VirtualNetwork(event_loop.call_later, event_loop.time)
        self.vehicles: dict[str, VirtualVehicle] = {}
        self.world = World(mission.obstacles)
        self._event_loop = event_loop
        self._watch = watch
        self._steps = 0
        self._due_s = event_loop.time()
        self._stopped = asyncio.Event()

    def stop(self) -> None:
        """Everything worth seeing has been seen: end here, wherever the vehicles are."""
        self._stopped.set()

    async def until_stopped(self) -> None:
        await self._stopped.wait()

    def spend(self, duration_s: float) -> None:
        """A vehicle's interpreter computes for `duration_s`, and its tasks wait; autopilots, repeats and cameras go on.

        All vehicles share one interpreter here, so the others' tasks wait as well.
        """
        end_s = self._event_loop.time() + duration_s
        while (left_s := end_s - self._event_loop.time()) > 0.0:
            self._event_loop.spend(min(left_s, STEP_S))
            self._catch_up()

    async def run_physics(self) -> None:
        """Everything outside the vehicle processes: the autopilots, MAVSDK's threads, the cameras' pictures. Until cancelled."""
        while True:
            self._catch_up()
            if self._watch is not None:
                self._watch(self)
            await asyncio.sleep(STEP_S)

    def _catch_up(self) -> None:
        """Move everything to the present."""
        while self._due_s <= self._event_loop.time() + 0.5 * STEP_S:
            self._due_s += STEP_S
            for one in self.vehicles.values():
                one.autopilot.repeat()
                for packet in one.station.step():
                    one.autopilot.receive(packet)
                period = round(1.0 / (one.rooms.profile.camera.rate_hz * STEP_S))
                self._see(one, picture_due=self._steps % period == 0)
            self._steps += 1

    def _see(self, one: VirtualVehicle, *, picture_due: bool) -> None:
        """The camera of one vehicle, and its perception thread where there are real pictures."""
        if one.camera is not None and picture_due and one.camera.shoot() and not one.hung:
            one.loop.wake_from_thread()
        if one.rendered is not None and one.loop.perception is not None:
            if picture_due:
                others = [other.station.core for other in self.vehicles.values() if other is not one]
                one.rendered.shoot(one.station.core, others)
            if not one.hung:
                one.loop.perception.step()


Watch = Callable[[VirtualFleet], None]
"""Called every STEP_S of virtual time: observe, break, judge."""

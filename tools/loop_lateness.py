"""How late the control loop ticks while perception runs in its process: the runtime's own loop, perception, planner, supervisor
and recorder on depth frames from shared memory, with another process in the camera's place and no autopilot.

    python tools/loop_lateness.py --rate 30 --rate 90 --seconds 20

A tick is due when a frame has been processed, or at its deadline when none came; late is from then to its start. On a machine
that has other work the figures tell of that work too: "machine" is how late a bare sleep of 1 ms wakes in a process of its own
meanwhile. Measure alone, or before everything else with `sudo chrt -r 1 python tools/loop_lateness.py`.
"""

from __future__ import annotations

import argparse
import asyncio
import gc
import multiprocessing
import sys
import tempfile
import threading
import time
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from flightapp.config.mission import load_mission
from flightapp.config.profile import load_profile
from flightapp.core.clock import SystemClock
from flightapp.core.types import Setpoint, VehicleState
from flightapp.estimation.target_filter import TargetFilter
from flightapp.fleet.session import open_session
from flightapp.fleet.team import Team
from flightapp.recording.recorder import Recorder
from flightapp.runtime.composition import build_perception, build_strategy, limits_of, surveyed_obstacles
from flightapp.runtime.control_loop import ControlLoop, Guidance
from flightapp.runtime.heartbeat import Heartbeat
from flightapp.runtime.journal import Journal
from flightapp.runtime.rooms import Rooms
from flightapp.runtime.vehicle_process import THREAD_SWITCH_S
from flightapp.safety.supervisor import make_supervisor
from flightapp.sim.camera import intrinsics_of
from flightapp.sim.world import World
from flightapp.vehicle.autopilot import Motion, Status
from flightapp.vehicle.pose_history import PoseHistory
from perception.geometry import camera_pose
from perception.sources.shared_memory import SharedMemoryWriter
from perception.synthetic.depth_renderer import DEPTH_UNIT_M, DepthRenderer
from perception.types import VehiclePose

ROOT = Path(__file__).parents[1]
MISSION, PROFILE, VEHICLE = ROOT / "missions/demo_two_pursuers.toml", ROOT / "profiles/sim.toml", "p1"
IMAGES = 16
WARM_UP_S = 2.0


class HoveringAutopilot:
    """Says 50 times a second that the vehicle hovers at the edge of the obstacles, and takes every setpoint."""

    def __init__(self, clock: SystemClock, history: PoseHistory) -> None:
        self._clock, self._history = clock, history
        self._motion: Motion | None = None
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._tell, daemon=True)
        self._thread.start()

    def _tell(self) -> None:
        while not self._stopping.wait(0.02):
            now_s = self._clock.now_s()
            state = VehicleState(now_s, np.array([6.0, 0.0, -5.0]), np.zeros(3), 0.0)
            self._history.append_state(state)
            self._history.append_attitude(now_s, 0.0, 0.0, 0.0)
            self._motion = Motion(state, 0.0, 0.0, now_s)

    def motion(self) -> Motion | None:
        return self._motion

    def status(self) -> Status:
        return Status(True, "OFFBOARD", True, "IN_AIR", self._clock.now_s())

    def send(self, setpoint: Setpoint) -> None: ...

    def battery(self) -> None: ...

    def take_status_texts(self) -> list[tuple[float, str, str]]:
        return []

    def close(self) -> None:
        self._stopping.set()
        self._thread.join()


def show_frames(path: Path, rate_hz: float) -> None:
    """The camera's place: rendered images, over and over."""
    mission, camera = load_mission(MISSION), load_profile(PROFILE).camera
    renderer = DepthRenderer(World(mission.obstacles), intrinsics_of(camera), range_min_m=camera.range_min_m)
    pose = camera_pose(VehiclePose((6.0, 0.0, -5.0), (0.0, 0.0, 0.0), 0.0, 0.0, 0.0), camera.mounting)
    images = [renderer.render(pose, number) for number in range(IMAGES)]
    writer = SharedMemoryWriter(path, intrinsics_of(camera), DEPTH_UNIT_M)
    due_s = time.monotonic()
    for number in range(sys.maxsize):
        due_s = max(due_s + 1.0 / rate_hz, time.monotonic())
        time.sleep(max(0.0, due_s - time.monotonic()))
        writer.write(images[number % IMAGES], time.monotonic_ns())


def watch_machine(seconds: float, found: multiprocessing.SimpleQueue[list[float]]) -> None:
    """How late a bare sleep wakes; says first that it is there, for its start takes a core."""
    found.put([])
    late, end_s = [], time.monotonic() + seconds
    while time.monotonic() < end_s:
        due_s = time.monotonic() + 0.001
        time.sleep(0.001)
        late.append(time.monotonic() - due_s)
    found.put(late)


async def measure(rate_hz: float, seconds: float) -> None:
    """One line for `rate_hz`."""
    mission, clock, history = load_mission(MISSION), SystemClock(), PoseHistory()
    profile = load_profile(PROFILE)
    vehicle = mission.vehicle(VEHICLE)
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(dir="/dev/shm")))
        profile = profile.model_copy(update={"camera": profile.camera.model_copy(update={"path": folder / "depth"})})
        recorder = stack.enter_context(Recorder(folder / "bench.mcap", options=profile.recording, mission=mission))
        session = await open_session([], [])
        stack.callback(session.close)
        autopilot = HoveringAutopilot(clock, history)
        stack.callback(autopilot.close)
        filtered = TargetFilter()
        rooms = Rooms(
            clock=clock,
            mission=mission,
            mission_digest="",
            vehicle=vehicle,
            profile=profile,
            limits=limits_of(vehicle, profile),
            autopilot=autopilot,
            planner=build_strategy(mission, vehicle, profile, MISSION, 0),
            supervisor=make_supervisor(mission, profile, VEHICLE),
            target_filter=filtered,
            team=Team(session, mission.fleet, VEHICLE, [], lambda _peer, _text: None),
            journal=Journal(recorder, clock, VEHICLE),
            heartbeat=Heartbeat(None),
            boundary=mission.boundary.as_boundary(),
            surveyed=surveyed_obstacles(mission),
        )
        loop = ControlLoop(rooms, lambda _command: (False, "this is a measurement"))
        loop.guidance = Guidance.PLANNER
        loop.perception = build_perception(vehicle, profile, clock, history, loop.wake_from_thread, recorder)
        spawned = multiprocessing.get_context("spawn")
        camera = spawned.Process(target=show_frames, args=(folder / "depth", rate_hz), daemon=True)
        found: multiprocessing.SimpleQueue[list[float]] = spawned.SimpleQueue()
        machine = spawned.Process(target=watch_machine, args=(WARM_UP_S + seconds, found), daemon=True)
        camera.start()
        stack.callback(camera.terminate)
        loop.perception.start()
        stack.callback(loop.perception.stop)
        while loop.perception.newest is None:
            if loop.perception.failure is not None:
                raise SystemExit(loop.perception.failure)
            await asyncio.sleep(0.05)
        gc.collect()
        gc.freeze()
        task = asyncio.create_task(loop.run())
        machine.start()
        await asyncio.to_thread(found.get)
        await follow_target(filtered, clock, WARM_UP_S)
        loop.lateness_s.clear()
        before, cpu_s, began_s = loop.perception.health.processed, time.process_time(), clock.now_s()
        await follow_target(filtered, clock, seconds)
        task.cancel()
        late_ms = np.array(loop.lateness_s) * 1e3
        took_s = clock.now_s() - began_s
        frames_hz = (loop.perception.health.processed - before) / took_s
        bare_ms = np.array(found.get()) * 1e3
        print(
            f"{rate_hz:5.0f} Hz asked, {frames_hz:5.1f} Hz processed, {len(late_ms) / took_s:5.1f} ticks/s: "
            f"late p50 {np.percentile(late_ms, 50):.2f}, p99 {np.percentile(late_ms, 99):.2f}, max {late_ms.max():.1f} ms; "
            f"CPU {(time.process_time() - cpu_s) / took_s:.0%} of a core; "
            f"machine: p50 {np.percentile(bare_ms, 50):.2f}, p99 {np.percentile(bare_ms, 99):.2f}, max {bare_ms.max():.1f} ms",
            flush=True,
        )


async def follow_target(filtered: TargetFilter, clock: SystemClock, seconds: float) -> None:
    """Measure a target that flies past, 20 times a second, so that the planner has something to plan."""
    end_s = clock.now_s() + seconds
    while (now_s := clock.now_s()) < end_s:
        east_m = -10.0 + now_s % 20.0
        filtered.update(now_s, np.array([25.0, east_m, -5.0]), np.array([0.0, 1.0, 0.0]), 0.1, 0.2)
        await asyncio.sleep(0.05)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rate", type=float, action="append", help="frames a second (repeatable); default 30 and 90")
    parser.add_argument("--seconds", type=float, default=20.0)
    options = parser.parse_args()
    sys.setswitchinterval(THREAD_SWITCH_S)
    for rate_hz in options.rate or (30.0, 90.0):
        asyncio.run(measure(rate_hz, options.seconds))


if __name__ == "__main__":
    main()

"""The process that flies one vehicle: `flightapp fly` starts it under the deadman, in simulation as on the aircraft."""

from __future__ import annotations

import argparse
import asyncio
import gc
import hashlib
import logging
import os
import signal
import sys
from contextlib import AsyncExitStack, suppress
from pathlib import Path

import flightapp
from flightapp.config.mission import load_mission
from flightapp.config.profile import load_profile
from flightapp.core.clock import SystemClock
from flightapp.core.errors import FlightError, InputError
from flightapp.core.line_log import LineLog
from flightapp.core.parent_death import signal_on_parent_death
from flightapp.estimation.target_filter import TargetFilter
from flightapp.fleet.session import open_session
from flightapp.fleet.team import Team
from flightapp.recording.recorder import Recorder
from flightapp.runtime.composition import build_perception, build_strategy, limits_of, surveyed_obstacles
from flightapp.runtime.control_loop import ControlLoop
from flightapp.runtime.executive import Executive
from flightapp.runtime.heartbeat import Heartbeat
from flightapp.runtime.inputs import check_inputs
from flightapp.runtime.journal import Journal
from flightapp.runtime.outcome import Outcome
from flightapp.runtime.rooms import Rooms
from flightapp.safety.supervisor import make_supervisor
from flightapp.vehicle.pose_history import PoseHistory
from flightapp.vehicle.px4 import Px4

EXIT_STATUS = {
    Outcome.CAPTURED: 0,
    Outcome.ESCAPED: 1,
    Outcome.TIMEOUT: 1,
    Outcome.ABORTED: 1,
    Outcome.FAULT: 3,
}
THREAD_SWITCH_S = 0.0005
"""How long the perception thread may keep the interpreter from the control loop."""


async def fly(mission_path: Path, profile_path: Path, name: str, run: Path, seed: int, heartbeat: Heartbeat) -> Outcome:
    """Fly vehicle `name`. Everything that can be refused is refused before the autopilot is touched."""
    mission, profile = load_mission(mission_path), load_profile(profile_path)
    vehicle = check_inputs(mission, profile, mission_path, profile_path, name)
    clock = SystemClock()
    planner = build_strategy(mission, vehicle, profile, mission_path, seed)
    supervisor = make_supervisor(mission, profile, name)
    async with AsyncExitStack() as stack:
        recorder = stack.enter_context(Recorder(run / f"{name}.mcap", options=profile.recording, mission=mission))
        recorder.metadata(
            "run",
            {
                "vehicle": name,
                "role": vehicle.role,
                "mission": mission.name,
                "strategy": vehicle.strategy.name,
                "seed": seed,
                "flightapp": flightapp.__version__,
            },
        )
        recorder.attach("mission.toml", mission_path)
        recorder.attach("profile.toml", profile_path)
        journal = Journal(recorder, clock, name)
        session = await open_session(profile.network.listen_endpoints, profile.network.connect_endpoints)
        stack.callback(session.close)
        others = [other.name for other in mission.vehicles if other.name != name]
        team = Team(session, mission.fleet, name, others, lambda peer, text: journal.event("warning", "network", text, peer=peer))
        history = PoseHistory()
        autopilot = Px4(profile.autopilot, vehicle.system_id, mission.datum.as_point(), clock, history)
        stack.callback(autopilot.close)
        rooms = Rooms(
            clock=clock,
            mission=mission,
            mission_digest=hashlib.sha256(mission_path.read_bytes()).hexdigest()[:12],
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
        )
        journal.event("info", "recording", str(recorder.path))
        try:
            journal.event("info", "autopilot", await autopilot.connect())
        except FlightError as error:
            journal.event("error", "fault", str(error))
            journal.phase("done", str(error), Outcome.FAULT.value)
            raise
        executive = Executive(rooms)
        loop = ControlLoop(rooms, executive.on_command)
        executive.attach(loop)
        if vehicle.camera and profile.camera.source != "none":
            loop.perception = build_perception(vehicle, profile, clock, history, loop.wake_from_thread, recorder)
            stack.callback(loop.perception.stop)
            loop.perception.start()
        for number in (signal.SIGTERM, signal.SIGINT):
            asyncio.get_running_loop().add_signal_handler(number, executive.request_landing, signal.Signals(number).name)
        gc.collect()
        gc.freeze()
        task = asyncio.create_task(loop.run(), name="control loop")
        try:
            return await executive.fly()
        finally:
            await _publish_the_end(loop)
            task.cancel()
            with suppress(asyncio.CancelledError):
                await task
            autopilot.close()  # The deadman watches until MAVSDK, and with it its repeats, is gone.
            heartbeat.beat(active=False)


async def _publish_the_end(loop: ControlLoop) -> None:
    """A few more ticks, so that the others hear the last state."""
    ticks = loop.ticks
    with suppress(TimeoutError):
        async with asyncio.timeout(1.0):
            while loop.ticks < ticks + 5:
                await asyncio.sleep(0.02)


def main(arguments: list[str] | None = None) -> int:
    """Parse, fly, and turn the outcome into an exit status."""
    parser = argparse.ArgumentParser(prog="python -m flightapp.runtime.vehicle_process", description=__doc__)
    parser.add_argument("--mission", type=Path, required=True)
    parser.add_argument("--profile", type=Path, required=True)
    parser.add_argument("--vehicle", required=True)
    parser.add_argument("--run", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--heartbeat-fd", type=int, default=None)
    options = parser.parse_args(arguments)
    log = LineLog.install()
    if options.heartbeat_fd is not None:
        signal_on_parent_death(signal.SIGTERM, os.getppid())
    sys.setswitchinterval(THREAD_SWITCH_S)
    heartbeat = Heartbeat(options.heartbeat_fd)
    try:
        outcome = asyncio.run(fly(options.mission, options.profile, options.vehicle, options.run, options.seed, heartbeat))
    except InputError as error:
        logging.getLogger(options.vehicle).error("%s", error)
        return 2
    except FlightError as error:
        logging.getLogger(options.vehicle).error("%s", error)
        return 3
    except Exception:
        logging.getLogger(options.vehicle).exception("vehicle process")
        return 3
    finally:
        log.close()
    return EXIT_STATUS[outcome]


if __name__ == "__main__":
    sys.exit(main())

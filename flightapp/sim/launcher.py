"""`flightapp sim`: every vehicle of a mission on this machine, each with its own vehicle process, mock autopilot and camera.

The vehicle processes are the ones that `flightapp fly` starts on a companion computer; only their profiles name local
links. The launcher flies nothing: it starts, watches, records the true states, passes on a person's wish to stop, and
makes sure that nothing is left behind.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import shutil
import signal
import sys
from dataclasses import dataclass, field
from pathlib import Path

import orjson

import flightapp
from flightapp.config.mission import Mission
from flightapp.config.profile import Profile
from flightapp.core.clock import SystemClock
from flightapp.core.errors import FlightError
from flightapp.fleet.command import new_command
from flightapp.fleet.operator import Operator
from flightapp.fleet.security.access import OPERATOR, membership_of
from flightapp.fleet.session import open_session
from flightapp.fleet.view import FleetView
from flightapp.recording.live import LiveView, url_file
from flightapp.recording.messages import TruthRecord
from flightapp.recording.recorder import Recorder
from flightapp.sim.fleet_files import HOST, ReservedPorts, VehicleFiles, prepare, shared_folder
from flightapp.sim.progress import Progress
from flightapp.sim.truth import TruthReader

TRUTH_PERIOD_S = 0.02
PROGRESS_PERIOD_S = 0.1
FILE_TIMEOUT_S = 30.0
LAND_ANSWER_S = 1.0
LANDING_TIMEOUT_S = 90.0
MARGIN_S = 300.0
KILL_AFTER_S = 3.0
THREADS = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")


@dataclass(slots=True)
class Processes:
    """Everything that was started, by name."""

    flights: dict[str, asyncio.subprocess.Process] = field(default_factory=dict)
    helpers: dict[str, asyncio.subprocess.Process] = field(default_factory=dict)


class Launcher:
    """Runs one mission; `stop` may be called at any time, from a signal handler."""

    def __init__(
        self,
        mission: Mission,
        profile: Profile,
        mission_path: Path,
        run: Path,
        seed: int,
        progress: Progress,
        keys: Path | None = None,
        live: LiveView | None = None,
    ) -> None:
        self._mission = mission
        self._profile = profile
        self._mission_path = mission_path.resolve()
        self._run = run
        self._seed = seed
        self._progress = progress
        self._keys = keys
        self._live = live
        self._live_unknown = set() if live is None else {vehicle.name for vehicle in mission.vehicles}
        self._clock = SystemClock()
        self._started_s = self._clock.now_s()
        self._processes = Processes()
        self._stops = 0
        self._announced: set[str] = set()

    async def run(self) -> dict[str, int]:
        """Fly the mission; the exit status of each vehicle process."""
        ports = ReservedPorts(2 * len(self._mission.vehicles))
        shared = shared_folder()
        loop = asyncio.get_running_loop()
        for number in (signal.SIGINT, signal.SIGTERM):
            loop.add_signal_handler(number, self.stop)
        try:
            files = prepare(self._mission, self._profile, self._run, shared, ports.numbers, self._keys)
            shutil.copyfile(self._mission_path, self._run / "mission.toml")
            await self._start(files)
            statuses = await self._watch(files)
        finally:
            await self._end_everything()
            ports.release()
            shutil.rmtree(shared, ignore_errors=True)
            for number in (signal.SIGINT, signal.SIGTERM):
                loop.remove_signal_handler(number)
        self._write_run_facts(statuses)
        return statuses

    def stop(self) -> None:
        """First call: land every vehicle. Second call: end everything at once."""
        self._stops += 1
        if self._stops == 1:
            self._progress.say("stopping: every vehicle lands; press Ctrl-C again to end at once")

    async def _start(self, files: list[VehicleFiles]) -> None:
        for own in files:
            await self._start_helper(f"{own.vehicle.name}-autopilot", self._mock_command(own))
        for own in files:
            await self._file_exists(own.truth, f"{own.vehicle.name}-autopilot")
            if own.vehicle.camera:
                await self._start_helper(f"{own.vehicle.name}-camera", self._camera_command(own, files))
        for own in files:
            if own.vehicle.camera:
                await self._file_exists(own.camera, f"{own.vehicle.name}-camera")
        for own in files:
            self._processes.flights[own.vehicle.name] = await self._spawn(own.vehicle.name, self._fly_command(own))

    def _mock_command(self, own: VehicleFiles) -> list[str]:
        return [
            *("-m", "flightapp.sim.mock_autopilot", "--mission", str(self._mission_path), "--vehicle", own.vehicle.name),
            *("--profile", str(own.profile), "--send-to", f"{HOST}:{own.mavlink_port}", "--truth", str(own.truth)),
            *("--seed", str(self._seed), "--log", str(self._run / f"{own.vehicle.name}-autopilot.jsonl")),
            *("--param", "COM_OBL_RC_ACT=4", "--param", "COM_RC_OVERRIDE=3", "--param", "COM_LOW_BAT_ACT=3", "--die-with-parent"),
        ]

    def _camera_command(self, own: VehicleFiles, files: list[VehicleFiles]) -> list[str]:
        others = [argument for other in files if other is not own for argument in ("--other-truth", str(other.truth))]
        return [
            *("-m", "flightapp.sim.camera", "--mission", str(self._mission_path), "--profile", str(own.profile)),
            *("--vehicle", own.vehicle.name, "--truth", str(own.truth), "--output", str(own.camera)),
            *("--seed", str(self._seed), "--die-with-parent", *others),
        ]

    def _fly_command(self, own: VehicleFiles) -> list[str]:
        return [
            *("-m", "flightapp", "fly", str(self._mission_path), "--profile", str(own.profile)),
            *("--vehicle", own.vehicle.name, "--run", str(self._run), "--seed", str(self._seed)),
            *self._live_arguments(own.vehicle.name),
        ]

    def _live_arguments(self, name: str) -> list[str]:
        """A server for each vehicle, as on its own computer: ports one after the other from the given one."""
        if self._live is None:
            return []
        index = [vehicle.name for vehicle in self._mission.vehicles].index(name)
        port = self._live.port + index if self._live.port else 0
        return ["--live", str(port), "--live-address", self._live.address]

    def _announce_live(self) -> None:
        """Say it once where each live view is."""
        for name in sorted(self._live_unknown):
            with contextlib.suppress(FileNotFoundError):
                self._progress.say(f"live view of {name}: {url_file(self._run, name).read_text().strip()}")
                self._live_unknown.discard(name)

    async def _start_helper(self, name: str, arguments: list[str]) -> None:
        self._processes.helpers[name] = await self._spawn(name, arguments)

    async def _spawn(self, name: str, arguments: list[str]) -> asyncio.subprocess.Process:
        """Start a Python process in a session of its own, so that the terminal's Ctrl-C reaches only the launcher."""
        with (self._run / f"{name}.log").open("wb") as log:
            return await asyncio.create_subprocess_exec(
                *self._command(name, arguments),
                stdin=asyncio.subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                start_new_session=True,
                env={**os.environ, **THREADS},
            )

    def _command(self, name: str, arguments: list[str]) -> list[str]:  # noqa: ARG002
        """What is executed for `name`, a vehicle or a helper of one; a network campaign puts it somewhere else."""
        return [sys.executable, *arguments]

    async def _file_exists(self, path: Path, maker: str) -> None:
        deadline = self._clock.now_s() + FILE_TIMEOUT_S
        while not path.exists():
            if self._processes.helpers[maker].returncode is not None or self._clock.now_s() > deadline:
                raise FlightError(f"{maker} did not start: {self._last_words(maker)}")
            await asyncio.sleep(0.02)

    async def _watch(self, files: list[VehicleFiles]) -> dict[str, int]:
        """Until every vehicle process has ended: record the truth, show progress, pass on the wish to stop."""
        readers = {own.vehicle.name: TruthReader(own.truth) for own in files}
        membership = membership_of(self._mission, None if self._keys is None else self._keys / OPERATOR)
        session = await open_session([], [own.fleet_endpoint for own in files], membership=membership)
        view = FleetView(session, self._mission.fleet, readers)
        operator = Operator(session, self._mission.fleet, self._clock)
        deadline = self._started_s + self._mission.start_timeout_s + self._mission.time_limit_s + MARGIN_S
        passed_on = 0
        shown_s = 0.0
        stopping: asyncio.Task[None] | None = None
        try:
            with Recorder(self._run / "truth.mcap", mission=self._mission) as recorder:
                recorder.metadata("run", {"mission": self._mission.name, "seed": self._seed, "flightapp": flightapp.__version__})
                while any(process.returncode is None for process in self._processes.flights.values()):
                    now_s = self._clock.now_s()
                    self._record_truth(readers, recorder)
                    self._announce_ends()
                    self._announce_live()
                    if now_s - shown_s >= PROGRESS_PERIOD_S:
                        shown_s = now_s
                        view.poll(now_s)
                        self._progress.show(now_s - self._started_s, view.states, self._failed())
                    if now_s > deadline and self._stops == 0:
                        self._progress.say(f"no end within {deadline - self._started_s:.0f} s: landing every vehicle")
                        self._stops = 1
                    if self._stops > 1 or (passed_on and now_s > deadline):
                        break
                    if self._stops == 1 and not passed_on:
                        passed_on, deadline = 1, now_s + LANDING_TIMEOUT_S
                        stopping = asyncio.create_task(self._land_all(operator))
                    await asyncio.sleep(max(0.0, TRUTH_PERIOD_S - (self._clock.now_s() - now_s)))
                view.poll(self._clock.now_s())
                self._progress.show(self._clock.now_s() - self._started_s, view.states, self._failed())
        finally:
            if stopping is not None:
                await stopping
            await asyncio.to_thread(session.close)
            for reader in readers.values():
                reader.close()
        return {
            name: 3 if process.returncode is None else process.returncode for name, process in self._processes.flights.items()
        }

    async def _land_all(self, operator: Operator) -> None:
        """Ask over the network, and by signal whoever did not answer."""
        answers = await operator.send(new_command("land", self._clock), self._processes.flights, LAND_ANSWER_S)
        answered = {answer.vehicle for answer in answers if answer.accepted}
        for name, process in self._processes.flights.items():
            if name not in answered and process.returncode is None:
                process.terminate()

    def _failed(self) -> set[str]:
        return {name for name, process in self._processes.flights.items() if process.returncode not in (None, 0, 1)}

    def _announce_ends(self) -> None:
        """Say it once when a vehicle process, autopilot or camera ends."""
        for name, process in (*self._processes.flights.items(), *self._processes.helpers.items()):
            if process.returncode is not None and name not in self._announced:
                self._announced.add(name)
                if process.returncode != 0:
                    self._progress.say(f"{name}: ended with status {process.returncode}: {self._last_words(name)}")

    def _record_truth(self, readers: dict[str, TruthReader], recorder: Recorder) -> None:
        for name, reader in readers.items():
            truth = reader.read()
            if truth is None:
                continue
            t_s = self._clock.from_monotonic_ns(truth.monotonic_ns)
            recorder.log(
                "/truth",
                TruthRecord(
                    t_s,
                    name,
                    list(truth.position_ned_m),
                    list(truth.velocity_ned_m_s),
                    truth.yaw_rad,
                    truth.armed,
                    truth.on_ground,
                ),
                t_s,
            )

    async def _end_everything(self) -> None:
        """Terminate what still runs, vehicles first; kill what does not obey."""
        for group in (self._processes.flights, self._processes.helpers):
            alive = [process for process in group.values() if process.returncode is None]
            for process in alive:
                with contextlib.suppress(ProcessLookupError):
                    process.terminate()
            if self._stops < 2 and alive:
                await asyncio.wait([asyncio.create_task(process.wait()) for process in alive], timeout=KILL_AFTER_S)
            for process in alive:
                if process.returncode is None:
                    with contextlib.suppress(ProcessLookupError):
                        os.killpg(process.pid, signal.SIGKILL)
                    await process.wait()

    def _last_words(self, name: str) -> str:
        lines = (self._run / f"{name}.log").read_text(errors="replace").strip().splitlines()
        return lines[-1] if lines else "it said nothing"

    def _write_run_facts(self, statuses: dict[str, int]) -> None:
        facts = {"mission": self._mission.name, "seed": self._seed, "exit_status": statuses, "stopped_by_person": self._stops > 0}
        (self._run / "run.json").write_bytes(orjson.dumps(facts, option=orjson.OPT_INDENT_2))

"""One `flightapp sim` from the mission file to the summary."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flightapp.analysis import report
from flightapp.config.mission import load_mission
from flightapp.config.profile import load_profile
from flightapp.core.errors import InputError
from flightapp.recording.live import LiveView
from flightapp.recording.run_folder import create_run_folder, given_run_folder
from flightapp.runtime.composition import build_strategy
from flightapp.runtime.inputs import check_inputs
from flightapp.runtime.outcome import EXIT_STATUS, Outcome
from flightapp.sim.fault_script import load_fault_script
from flightapp.sim.fleet_keys import fleet_keys
from flightapp.sim.launcher import Launcher
from flightapp.sim.progress import Progress


@dataclass(frozen=True, slots=True)
class SimulationResult:
    """What a run came to."""

    summary: dict[str, Any]
    run: Path
    page: Path
    exit_status: int
    faults: tuple[str, ...]
    """One sentence for each vehicle process that failed."""

    def text(self) -> str:
        """A few lines for a person."""
        summary = self.summary
        lines = [f"outcome: {summary['outcome']}", *self.faults]
        for label, name, unit in (
            ("captured after", "capture_time_s", "s"),
            ("smallest clearance to an obstacle", "min_obstacle_clearance_m", "m"),
            ("smallest separation of the pursuers", "min_separation_m", "m"),
            ("evader's distance to the boundary", "boundary_distance_m", "m"),
        ):
            value = summary.get(name)
            if isinstance(value, (int, float)):
                lines.append(f"{label}: {value:.2f} {unit}")
        lines.append(f"recordings: {self.run}")
        lines.append(f"report: {self.page}")
        return "\n".join(lines)


async def simulate(
    mission_path: Path,
    profile_path: Path,
    seed: int,
    folder: Path | None,
    *,
    certificates: Path | None = None,
    secure: bool = False,
    live: LiveView | None = None,
) -> SimulationResult:
    """Check every input, fly, analyse. InputError before anything was started.

    certificates: folder of `flightapp keys` with which the fleet talks; secure without it: temporary ones.
    live: where the first vehicle serves its live view; the others take the ports after it.
    """
    mission, profile = load_mission(mission_path), load_profile(profile_path)
    for vehicle in mission.vehicles:
        check_inputs(mission, profile, mission_path, profile_path, vehicle.name)
        build_strategy(mission, vehicle, profile, mission_path, seed)
    for name, script in mission.simulation.faults.items():
        try:
            load_fault_script(mission_path.parent / script)
        except InputError as error:
            raise InputError(f"{mission_path}: simulation.faults.{name}: {error}") from None
    with fleet_keys(mission, certificates, temporary=secure) as keys:
        run = given_run_folder(folder) if folder is not None else create_run_folder(profile.recording.folder, mission.name)
        with Progress(mission.name) as progress:
            statuses = await Launcher(mission, profile, mission_path, run, seed, progress, keys, live).run()
    summary, page = report([run])
    failed = {name: status for name, status in statuses.items() if status not in (0, 1)}
    faults = tuple(f"fault: {name}: vehicle process ended with status {status}" for name, status in failed.items())
    outcome = Outcome(summary["outcome"]) if summary["outcome"] is not None else Outcome.FAULT
    return SimulationResult(summary, run, page, EXIT_STATUS[Outcome.FAULT if faults else outcome], faults)

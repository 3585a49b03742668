"""The fault campaign from its question to its answer."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import joblib
from joblib.externals.loky.process_executor import TerminatedWorkerError

from flightapp.analysis.campaign.output_folder import output_folder
from flightapp.analysis.campaign.progress import ProgressBar
from flightapp.analysis.campaign.workers import Workers, flown
from flightapp.analysis.summary import write_whole
from flightapp.config.consistency import check_mission_fits_profile
from flightapp.config.mission import load_mission
from flightapp.config.profile import load_profile
from flightapp.core.clock import monotonic_ns
from flightapp.core.errors import FlightError
from flightapp.sim.fault_campaign.flight import Verdict, fly_seed

NAME = "faults"


@dataclass(frozen=True, slots=True)
class FaultCampaign:
    """The question. `varies`: every seed changes the mission too."""

    mission: Path
    profile: Path
    seeds: tuple[int, ...]
    varies: bool


@dataclass(frozen=True, slots=True)
class FinishedFaults:
    """The answer, by rising seed; `complete` False where a person ended it early."""

    folder: Path
    verdicts: tuple[Verdict, ...]
    seconds: float
    complete: bool

    @property
    def is_clean(self) -> bool:
        return not any(verdict.violations for verdict in self.verdicts)

    @property
    def summary(self) -> dict[str, object]:
        """What machines get."""
        violations = [asdict(violation) for verdict in self.verdicts for violation in verdict.violations]
        return {
            "missions": len(self.verdicts),
            "seconds": round(self.seconds, 1),
            "complete": self.complete,
            "violations": violations,
        }


def run_fault_campaign(campaign: FaultCampaign, workers: Workers, output: Path | None) -> FinishedFaults:
    """Fly every seed; the recordings of those that violate an invariant stay, beside missions.json."""
    mission, profile = load_mission(campaign.mission), load_profile(campaign.profile)
    for vehicle in mission.vehicles:
        check_mission_fits_profile(mission, profile, campaign.mission, campaign.profile, vehicle.name)
    folder = output_folder(output, NAME, "--out")
    begun_ns = monotonic_ns()
    verdicts: list[Verdict] = []
    complete = True
    with ProgressBar(NAME, len(campaign.seeds)) as bar:
        try:
            for verdict in _flown(campaign, workers, folder):
                verdicts.append(verdict)
                bar.advance(1, f"violations: {sum(len(one.violations) for one in verdicts)}")
        except KeyboardInterrupt:
            complete = False
        except TerminatedWorkerError:
            raise FlightError("a worker process died, perhaps for lack of memory; use fewer --workers") from None
    if not complete:
        _clear(folder, campaign.seeds, verdicts)
    verdicts.sort(key=lambda verdict: verdict.seed)
    finished = FinishedFaults(folder, tuple(verdicts), (monotonic_ns() - begun_ns) * 1e-9, complete)
    told = {**finished.summary, "flown": [verdict.as_json() for verdict in verdicts]}
    write_whole(folder / "missions.json", (json.dumps(told, indent=2) + "\n").encode())
    return finished


def _flown(campaign: FaultCampaign, workers: Workers, folder: Path) -> Iterator[Verdict]:
    if workers.expected == 1:
        for seed in campaign.seeds:
            yield fly_and_tidy(campaign, seed, folder)
        return
    yield from flown(workers, [joblib.delayed(fly_and_tidy)(campaign, seed, folder) for seed in campaign.seeds])


def fly_and_tidy(campaign: FaultCampaign, seed: int, folder: Path) -> Verdict:
    """One seed; its recordings are kept only where something is wrong with it."""
    own = _folder(folder, seed)
    verdict = fly_seed(seed, campaign.mission, campaign.profile, own, varies=campaign.varies)
    if not verdict.violations:
        shutil.rmtree(own)
    return verdict


def _clear(folder: Path, seeds: Sequence[int], verdicts: Sequence[Verdict]) -> None:
    """Remove what was being flown when a person ended the campaign."""
    kept = {verdict.seed for verdict in verdicts}
    for seed in seeds:
        if seed not in kept:
            shutil.rmtree(_folder(folder, seed), ignore_errors=True)


def _folder(folder: Path, seed: int) -> Path:
    return folder / f"seed-{seed}"

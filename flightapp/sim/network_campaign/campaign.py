"""The network campaign from its question to its answer: every seed over every condition, so that conditions compare in pairs."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
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
from flightapp.core.errors import FlightError, InputError
from flightapp.sim.network_campaign.conditions import Condition
from flightapp.sim.network_campaign.flight import Flown, fly_condition
from flightapp.sim.network_campaign.picture import draw_campaign
from flightapp.sim.network_campaign.real.flight import RealFlown, fly_real
from flightapp.sim.network_campaign.table import Row, as_csv, as_markdown, rows_of

NAME = "network"


@dataclass(frozen=True, slots=True)
class NetworkCampaign:
    """The question.

    real: so many conditions, from the first to the last, are flown by real processes too, once each; `proxy`: through the proxy.
    """

    mission: Path
    profile: Path
    conditions: tuple[Condition, ...]
    seeds: tuple[int, ...]
    real: int = 0
    proxy: bool = False


@dataclass(frozen=True, slots=True)
class FinishedNetwork:
    """The answer; `complete` False where a person ended it early."""

    folder: Path
    flown: tuple[Flown, ...]
    real: tuple[RealFlown, ...]
    seconds: float
    complete: bool

    @property
    def rows(self) -> list[Row]:
        return rows_of(self.flown)

    @property
    def is_clean(self) -> bool:
        return not any([one.violations for one in self.flown] + [one.violations for one in self.real])

    @property
    def summary(self) -> dict[str, object]:
        """What machines get."""
        return {
            "missions": len(self.flown),
            "seconds": round(self.seconds, 1),
            "complete": self.complete,
            "conditions": [row.as_json() for row in self.rows],
            "real": [one.as_json() for one in self.real],
            "violations": [
                {"seed": one.seed, "folder": folder_name(one.condition, one.seed), "violation": text}
                for one in self.flown
                for text in one.violations
            ],
        }


def run_network_campaign(campaign: NetworkCampaign, workers: Workers, output: Path | None) -> FinishedNetwork:
    """Fly all of it; table.csv, table.md, network.png and missions.json go to the folder, and recordings of what went wrong."""
    _check(campaign)
    folder = output_folder(output, NAME, "--out")
    begun_ns = monotonic_ns()
    results: list[Flown] = []
    real: list[RealFlown] = []
    complete = True
    with ProgressBar(NAME, len(campaign.conditions) * len(campaign.seeds)) as bar:
        try:
            for one in _flown(campaign, workers, folder):
                results.append(one)
                captured = sum(each.captured for each in results)
                bar.advance(
                    1, f"captured: {captured}/{len(results)}, violations: {sum(len(each.violations) for each in results)}"
                )
            mission, profile = campaign.mission, campaign.profile
            real.extend(fly_real(one, mission, profile, folder, proxy=campaign.proxy) for one in _spread(campaign))
        except KeyboardInterrupt:
            complete = False
        except TerminatedWorkerError:
            raise FlightError("a worker process died, perhaps for lack of memory; use fewer --workers") from None
    if not complete:
        _clear(campaign, folder, results)
    results.sort(key=lambda one: (one.condition, one.seed))
    finished = FinishedNetwork(folder, tuple(results), tuple(real), (monotonic_ns() - begun_ns) * 1e-9, complete)
    _write(finished)
    return finished


def _check(campaign: NetworkCampaign) -> None:
    mission, profile = load_mission(campaign.mission), load_profile(campaign.profile)
    for vehicle in mission.vehicles:
        check_mission_fits_profile(mission, profile, campaign.mission, campaign.profile, vehicle.name)
    if {vehicle.role for vehicle in mission.vehicles} != {"pursuer", "evader"}:
        raise InputError(f"{campaign.mission}: a network campaign measures pursuits; name a mission with pursuers and an evader")


def _flown(campaign: NetworkCampaign, workers: Workers, folder: Path) -> Iterator[Flown]:
    tasks = [(condition, seed) for seed in campaign.seeds for condition in campaign.conditions]
    if workers.expected == 1:
        for condition, seed in tasks:
            yield fly_and_tidy(campaign, condition, seed, folder)
        return
    yield from flown(workers, [joblib.delayed(fly_and_tidy)(campaign, condition, seed, folder) for condition, seed in tasks])


def fly_and_tidy(campaign: NetworkCampaign, condition: Condition, seed: int, folder: Path) -> Flown:
    """One mission; its recordings are kept only where something is wrong with it."""
    own = folder / folder_name(condition, seed)
    result = fly_condition(condition, seed, campaign.mission, campaign.profile, own)
    if not result.violations:
        shutil.rmtree(own)
    return result


def folder_name(condition: Condition, seed: int) -> str:
    return f"{condition.partition}-{condition.delay_ms:g}ms-{condition.loss_percent:g}percent-seed-{seed}"


def _spread(campaign: NetworkCampaign) -> list[Condition]:
    """`real` conditions, evenly from the first to the last."""
    count = min(campaign.real, len(campaign.conditions))
    last = len(campaign.conditions) - 1
    return [campaign.conditions[round(last * index / max(count - 1, 1))] for index in range(count)]


def _clear(campaign: NetworkCampaign, folder: Path, results: list[Flown]) -> None:
    """Remove what was being flown when a person ended the campaign."""
    kept = {folder_name(one.condition, one.seed) for one in results}
    for condition in campaign.conditions:
        for seed in campaign.seeds:
            if folder_name(condition, seed) not in kept:
                shutil.rmtree(folder / folder_name(condition, seed), ignore_errors=True)


def _write(finished: FinishedNetwork) -> None:
    told = {**finished.summary, "flown": [one.as_json() for one in finished.flown]}
    write_whole(finished.folder / "missions.json", (json.dumps(told, indent=2) + "\n").encode())
    if finished.flown:
        write_whole(finished.folder / "table.csv", as_csv(finished.rows).encode())
        write_whole(finished.folder / "table.md", as_markdown(finished.rows).encode())
        write_whole(finished.folder / "network.png", draw_campaign(finished.rows))

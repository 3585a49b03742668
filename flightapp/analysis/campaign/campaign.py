"""One campaign from its question to its files."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from flightapp.analysis.campaign.drawing import Drawing
from flightapp.analysis.campaign.output_folder import output_folder
from flightapp.analysis.campaign.parquet import runs_parquet
from flightapp.analysis.campaign.progress import ProgressBar, Successes
from flightapp.analysis.campaign.recording import record
from flightapp.analysis.campaign.runner import Flown, fly_jobs, own_parameters, paired_jobs
from flightapp.analysis.campaign.seeds import seeds_text
from flightapp.analysis.campaign.summary import Summary, planner_details, summarise
from flightapp.analysis.campaign.table import markdown
from flightapp.analysis.campaign.trace import trace
from flightapp.analysis.campaign.workers import Workers
from flightapp.analysis.summary import write_whole
from flightapp.core.errors import InputError
from flightapp.planning.registry import make_planner, planner_names
from flightapp.sim.batch.facts import planner_parameters
from flightapp.sim.batch.scenario import Scenario

RECORDED_MAX = 32
RECORDINGS = "recordings"


@dataclass(frozen=True, slots=True)
class Campaign:
    """The question: which planners on which seeds. `parameters`: of every planner, on top of the scenario's."""

    scenario: Scenario
    planners: tuple[str, ...]
    seeds: tuple[int, ...]
    parameters: Mapping[str, object]
    drawing: Drawing
    record: bool = False

    def __post_init__(self) -> None:
        for number, planner in enumerate(self.planners):
            if planner not in planner_names():
                raise InputError(f"--planner {planner}: no such planner; known: {', '.join(planner_names())}")
            if planner in self.planners[:number]:
                raise InputError(f"--planner {planner}: named twice; name each planner once")
            parameters = planner_parameters(self.scenario, planner, own_parameters(planner, self.parameters))
            make_planner(planner, limits=self.scenario.pursuers.limits(), parameters=parameters)
        runs = len(self.planners) * len(self.seeds)
        if self.record and runs > RECORDED_MAX:
            raise InputError(f"--record: {runs} runs; at most {RECORDED_MAX} are recorded, so name fewer --seeds or planners")


@dataclass(frozen=True, slots=True)
class Finished:
    """The answer; `complete` False where a person ended it early. `summary` is what machines get."""

    folder: Path
    summary: Summary
    table: str
    complete: bool


def run_campaign(campaign: Campaign, workers: Workers, output: Path | None) -> Finished:
    """Fly it and write runs.parquet, summary.json, table.md, pictures and recordings; each file whole or not at all."""
    folder = output_folder(output, campaign.scenario.name)
    flown = _flown(campaign, workers)
    results = flown.results
    summary = summarise(campaign.scenario, seeds_text(campaign.seeds), campaign.planners, results)
    by_planner = {one["planner"]: [r for r in results if r.planner == one["planner"]] for one in summary["planners"]}
    details = {planner: planner_details(runs) for planner, runs in by_planner.items()}
    table = markdown(summary, details)
    write_whole(folder / "runs.parquet", runs_parquet(results))
    write_whole(
        folder / "summary.json", (json.dumps(_kept(campaign, summary, details, flown.complete), indent=2) + "\n").encode()
    )
    write_whole(folder / "table.md", table.encode())
    if flown.complete:
        _draw_and_record(campaign, flown, folder)
    return Finished(folder, summary, table, flown.complete)


def _flown(campaign: Campaign, workers: Workers) -> Flown:
    jobs = paired_jobs(campaign.planners, campaign.seeds)
    successes = Successes(campaign.planners)
    with ProgressBar(campaign.scenario.name, len(jobs)) as bar:
        return fly_jobs(
            campaign.scenario,
            jobs,
            workers,
            campaign.parameters,
            note=lambda results: bar.advance(len(results), successes.add(results)),
        )


def _kept(campaign: Campaign, summary: Summary, details: Mapping[str, Summary], complete: bool) -> Summary:
    """summary.json: the figures, what the table shows beside them, and everything that is needed to fly the same again."""
    return {
        **summary,
        "planners": [{**one, **details[one["planner"]]} for one in summary["planners"]],
        "complete": complete,
        "parameters": dict(campaign.parameters),
        "scenario_as_flown": campaign.scenario.model_dump(mode="json"),
    }


def _draw_and_record(campaign: Campaign, flown: Flown, folder: Path) -> None:
    for name, picture in campaign.drawing.files(campaign.scenario, campaign.planners, flown.results, campaign.parameters):
        write_whole(folder / name, picture)
    if campaign.record:
        for result in flown.results:
            again = trace(campaign.scenario, result.planner, result.seed, campaign.parameters)
            record(again, folder / RECORDINGS / f"{result.planner}-{result.seed}")

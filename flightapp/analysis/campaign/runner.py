"""Many seeded runs on many cores. Every run is a pure function of its job, so workers, chunks and order change nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import joblib
from joblib.externals.loky.process_executor import TerminatedWorkerError

from flightapp.analysis.campaign.workers import Workers, flown
from flightapp.core.errors import FlightError
from flightapp.planning.registry import file_parameters
from flightapp.sim.batch.episode import fly
from flightapp.sim.batch.result import RunResult
from flightapp.sim.batch.scenario import Scenario

Parameters = Mapping[str, object] | None
_CHUNK_MAX = 16
_CHUNKS_A_WORKER = 8


@dataclass(frozen=True, slots=True)
class Job:
    """One run."""

    planner: str
    seed: int


@dataclass(frozen=True, slots=True)
class Flown:
    """Results sorted by planner and seed; `complete` False where a person ended it early."""

    results: tuple[RunResult, ...]
    complete: bool


def paired_jobs(planners: Sequence[str], seeds: Sequence[int]) -> list[Job]:
    """Every planner on every seed; seed by seed, so that a campaign that is cut short has the same seeds of every planner."""
    return [Job(planner, seed) for seed in seeds for planner in planners]


def fly_jobs(
    scenario: Scenario,
    jobs: Sequence[Job],
    workers: Workers,
    parameters: Parameters = None,
    note: Callable[[Sequence[RunResult]], None] | None = None,
) -> Flown:
    """Fly all jobs; Ctrl-C ends it early and keeps what is finished.

    parameters: of every planner, on top of the scenario's, but for what a variant fixes.
    note: called with results as they come, in no particular order.
    """
    results: list[RunResult] = []
    complete = True
    try:
        for some in _flown(scenario, jobs, workers, parameters):
            results += some
            if note is not None:
                note(some)
    except KeyboardInterrupt:
        complete = False
    except TerminatedWorkerError:
        raise FlightError("a worker process died, perhaps for lack of memory; use fewer --workers") from None
    return Flown(tuple(sorted(results, key=lambda result: (result.planner, result.seed))), complete)


def own_parameters(planner: str, parameters: Parameters) -> dict[str, object]:
    """What of `parameters`, which serve all planners, is for `planner` to take: not what a variant fixes."""
    return file_parameters(planner, parameters or {})


def _flown(scenario: Scenario, jobs: Sequence[Job], workers: Workers, parameters: Parameters) -> Iterator[list[RunResult]]:
    if workers.backend == "local" and workers.expected == 1:
        for job in jobs:
            yield _fly_chunk(scenario, [job], parameters)
        return
    size = max(1, min(_CHUNK_MAX, len(jobs) // (_CHUNKS_A_WORKER * workers.expected)))
    chunks = [jobs[start : start + size] for start in range(0, len(jobs), size)]
    yield from flown(workers, [joblib.delayed(_fly_chunk)(scenario, chunk, parameters) for chunk in chunks])


def _fly_chunk(scenario: Scenario, jobs: Sequence[Job], parameters: Parameters) -> list[RunResult]:
    return [fly(scenario, job.planner, job.seed, own_parameters(job.planner, parameters)) for job in jobs]

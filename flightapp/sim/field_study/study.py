"""All methods on the paper's scenes and on random ones; the table beside the printed one."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path

import numpy as np

from flightapp.analysis.campaign.output_folder import output_folder
from flightapp.analysis.campaign.progress import ProgressBar
from flightapp.analysis.campaign.statistics import wilson_interval
from flightapp.analysis.campaign.table import aligned
from flightapp.analysis.summary import write_whole
from flightapp.core.errors import InputError
from flightapp.planning.adaptive_apf.paper_step import STEP_S
from flightapp.sim.field_study.flight import FieldFlight, collided, fly_scene
from flightapp.sim.field_study.gain_search import FIRST_SEED, SearchSize, searched_gains
from flightapp.sim.field_study.methods import METHODS, MOVING_GAINS, PRINTED, PRINTED_ONLY, STATIC_GAINS, gains_of, inertia_of
from flightapp.sim.field_study.picture import scenes_picture
from flightapp.sim.field_study.scenes import FieldScene, local_minimum, moving_obstacles, unreachable_target

STATIC_STEP_M = 0.02
STATIC_STEPS, RANDOM_STEPS = 2000, 2000
NAME = "apf"
SCENE_HEADINGS = ("scene", "method", "outcome", "steps", "escapes", "nearest to the goal m", "length m", "clearance m")
RANDOM_HEADINGS = (
    "method",
    "arrived %",
    "95 %",
    "collided %",
    "time s",
    "length m",
    "turn deg/s",
    "printed %",
    "printed s",
    "printed m",
    "printed deg/s",
)


@dataclass(frozen=True, slots=True)
class FieldStudy:
    """The question. literal: attraction and goal factor as printed; step_m: what the random scenes' difficulty follows from."""

    seeds: tuple[int, ...]
    methods: tuple[str, ...]
    step_m: float = 0.0325
    literal: bool = False
    search: SearchSize = field(default_factory=SearchSize)


@dataclass(frozen=True, slots=True)
class FinishedFieldStudy:
    folder: Path
    summary: dict[str, object]
    table: str


Searched = Mapping[str, Mapping[str, float]]
"""By the method's name, what was searched for it."""


def run_field_study(study: FieldStudy, output: Path | None) -> FinishedFieldStudy:
    """Fly all of it; table.md, scenes.png and apf.json go to the folder.

    InputError on names, numbers or a folder that cannot be.
    """
    for name in study.methods:
        if name not in METHODS:
            raise InputError(f'--method "{name}": no such method; known: {", ".join(METHODS)}')
    if not 0.001 <= study.step_m <= 0.5:
        raise InputError(f"--step-m {study.step_m}: must lie between 0.001 and 0.5")
    folder = output_folder(output, NAME, "--out")
    papers = (unreachable_target(), local_minimum(), moving_obstacles())
    flights = sum(study.search.flights(METHODS[name]) + len(papers) + len(study.seeds) for name in study.methods)
    with ProgressBar(NAME, flights) as bar:
        searched, searches = _searched(study, bar)
        flown = {name: [_fly(study, searched, scene, name, 0) for scene in papers] for name in study.methods}
        bar.advance(len(papers) * len(flown), "the paper's scenes")
        random = _random_scenes(study, searched, bar)
    scenes = [_scene_figures(scene, name, flown[name][index]) for index, scene in enumerate(papers) for name in study.methods]
    table = _as_text(study, scenes, random, searched)
    summary: dict[str, object] = {"study": asdict(study), "scenes": scenes, "random": random, "searched": searches}
    write_whole(folder / "apf.json", (json.dumps(summary, indent=2) + "\n").encode())
    write_whole(folder / "scenes.png", scenes_picture(papers, flown))
    write_whole(folder / "table.md", (table + "\n").encode())
    return FinishedFieldStudy(folder, summary, table)


def _searched(study: FieldStudy, bar: ProgressBar) -> tuple[Searched, dict[str, object]]:
    """What was found for each method that searches, and how the search went."""
    values: dict[str, Mapping[str, float]] = {}
    told: dict[str, object] = {}
    for name in study.methods:
        method = METHODS[name]
        advance = partial(_advance, bar, f"search for {name}")
        values[name], found = searched_gains(method, study.step_m, RANDOM_STEPS, study.search, advance, literal=study.literal)
        if found is not None:
            told[name] = {"found": values[name], "mean_cost": found.costs[-1], "mean_costs": list(found.costs)}
    return values, told


def _advance(bar: ProgressBar, figures: str, flights: int) -> None:
    bar.advance(flights, figures)


def _scene_figures(scene: FieldScene, name: str, flight: FieldFlight) -> dict[str, object]:
    return {
        "scene": scene.name,
        "method": name,
        "outcome": flight.outcome,
        "steps": flight.steps,
        "escapes": flight.escapes,
        "goal_gap_m": flight.goal_gap_m,
        "length_m": flight.length_m,
        "clearance_m": flight.clearance_m,
    }


def _random_scenes(study: FieldStudy, searched: Searched, bar: ProgressBar) -> list[dict[str, object]]:
    rows: list[dict[str, object]] = []
    for name in study.methods:
        flights: list[FieldFlight] = []
        for seed in study.seeds:
            flights.append(_fly(study, searched, moving_obstacles(seed), name, seed))
            bar.advance(1, name)
        rows.append({"method": name, **_figures(flights)})
    return rows


def _fly(study: FieldStudy, searched: Searched, scene: FieldScene, name: str, seed: int) -> FieldFlight:
    method, values = METHODS[name], searched[name]
    step_m, printed = (study.step_m, MOVING_GAINS) if scene.moves else (STATIC_STEP_M, STATIC_GAINS)
    gains = gains_of(method, step_m, printed, literal=study.literal, searched=values)
    steps = RANDOM_STEPS if scene.moves else STATIC_STEPS
    return fly_scene(scene, method, gains, step_m, steps, seed, inertia_of(method, values))


def _figures(flights: Sequence[FieldFlight]) -> dict[str, object]:
    arrived = [one for one in flights if one.arrived]
    low, high = wilson_interval(len(arrived), len(flights)) if flights else (0.0, 1.0)
    return {
        "flights": len(flights),
        "arrived": len(arrived),
        "arrived_ci95": [low, high],
        "collided": sum(collided(one) for one in flights),
        "time_s": float(np.mean([one.steps * STEP_S for one in arrived])) if arrived else None,
        "length_m": float(np.mean([one.length_m for one in arrived])) if arrived else None,
        "turn_max_deg_s": float(np.median([one.turn_max_deg_s for one in arrived])) if arrived else None,
    }


def _as_text(
    study: FieldStudy, scenes: Sequence[dict[str, object]], random: Sequence[dict[str, object]], searched: Searched
) -> str:
    told = [
        [
            str(one["scene"]),
            str(one["method"]),
            str(one["outcome"]),
            str(one["steps"]),
            str(one["escapes"]),
            f"{one['goal_gap_m']:.2f}",
            f"{one['length_m']:.2f}",
            f"{one['clearance_m']:.2f}",
        ]
        for one in scenes
    ]
    parts = [
        "The paper's scenes; it prints at most 1000 steps, this goes on to 2000.",
        aligned(SCENE_HEADINGS, told),
        f"Random scenes, {len(study.seeds)}, a step of {study.step_m:g} m; figures of flights that arrived: mean time "
        "in the air and length, median of the greatest turn between steps of 0.02 s. The printed lengths are shorter than the "
        "straight way of the printed scene (32.9 m), what the printed times are of is not said, and the printed turn rates have "
        "no time step: only trends compare.",
        aligned(RANDOM_HEADINGS, [*(_row(one) for one in random), *_printed_rows()]),
    ]
    size = study.search
    for name, values in searched.items():
        if values:
            how = {"draws": f"{size.draws} draws", "wolves": f"{size.wolves} grey wolves, {size.rounds} rounds"}
            gains = ", ".join(f"{key} {value:.2f}" for key, value in values.items())
            parts.append(f"{name}, found by {how[METHODS[name].search]} on {size.scenes} scenes from {FIRST_SEED} on: {gains}.")
    return "\n\n".join(parts)


def _row(one: dict[str, object]) -> list[str]:
    flights, arrived, collisions = one["flights"], one["arrived"], one["collided"]
    interval, figures = one["arrived_ci95"], (one["time_s"], one["length_m"], one["turn_max_deg_s"])
    assert isinstance(flights, int)
    assert isinstance(arrived, int)
    assert isinstance(collisions, int)
    assert isinstance(interval, list)
    printed = PRINTED[str(one["method"])]
    return [
        str(one["method"]),
        f"{100 * arrived / flights:.1f}",
        f"{100 * interval[0]:.1f}-{100 * interval[1]:.1f}",
        f"{100 * collisions / flights:.1f}",
        *("-" if value is None else f"{value:.1f}" for value in figures),
        *(f"{value:.2f}" for value in printed),
    ]


def _printed_rows() -> list[list[str]]:
    """What the paper has figures of and is not flown here."""
    return [[name, *("-" * 6), *(f"{value:.2f}" for value in printed)] for name, printed in PRINTED_ONLY.items()]

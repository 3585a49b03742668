"""All methods on the paper's scenes and on random ones; the table beside the printed one."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from flightapp.analysis.campaign.output_folder import output_folder
from flightapp.analysis.campaign.progress import ProgressBar
from flightapp.analysis.campaign.statistics import wilson_interval
from flightapp.analysis.campaign.table import aligned
from flightapp.analysis.summary import write_whole
from flightapp.core.errors import InputError
from flightapp.sim.field_study.flight import FieldFlight, collided, fly_scene
from flightapp.sim.field_study.methods import METHODS, MOVING_GAINS, PRINTED, STATIC_GAINS, gains_of
from flightapp.sim.field_study.scenes import FieldScene, local_minimum, moving_obstacles, unreachable_target

STATIC_STEP_M = 0.02
STATIC_STEPS, RANDOM_STEPS = 2000, 2000
NAME = "apf"
SCENE_HEADINGS = ("scene", "method", "outcome", "steps", "escapes", "nearest to the goal m", "length m")
RANDOM_HEADINGS = (
    "method",
    "arrived %",
    "95 %",
    "collided %",
    "length m",
    "turn deg/s",
    "printed %",
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


@dataclass(frozen=True, slots=True)
class FinishedFieldStudy:
    folder: Path
    summary: dict[str, object]
    table: str


def run_field_study(study: FieldStudy, output: Path | None) -> FinishedFieldStudy:
    """Fly all of it; table.md and apf.json go to the folder. InputError on names, numbers or a folder that cannot be."""
    for name in study.methods:
        if name not in METHODS:
            raise InputError(f'--method "{name}": no such method; known: {", ".join(METHODS)}')
    if not 0.001 <= study.step_m <= 0.5:
        raise InputError(f"--step-m {study.step_m}: must lie between 0.001 and 0.5")
    folder = output_folder(output, NAME, "--out")
    with ProgressBar(NAME, len(study.methods) * (3 + len(study.seeds))) as bar:
        scenes = _paper_scenes(study, bar)
        random = _random_scenes(study, bar)
    table = _as_text(study, scenes, random)
    summary: dict[str, object] = {"study": asdict(study), "scenes": scenes, "random": random}
    write_whole(folder / "apf.json", (json.dumps(summary, indent=2) + "\n").encode())
    write_whole(folder / "table.md", (table + "\n").encode())
    return FinishedFieldStudy(folder, summary, table)


def _paper_scenes(study: FieldStudy, bar: ProgressBar) -> list[dict[str, object]]:
    rows: list[dict[str, object]] = []
    for scene in (unreachable_target(), local_minimum(), moving_obstacles()):
        moving = bool(scene.phases.any() or scene.bodies[:, -3:].any())
        for name in study.methods:
            flight = _fly(study, scene, name, 0, is_static=not moving)
            rows.append(
                {
                    "scene": scene.name,
                    "method": name,
                    "outcome": flight.outcome,
                    "steps": flight.steps,
                    "escapes": flight.escapes,
                    "goal_gap_m": flight.goal_gap_m,
                    "length_m": flight.length_m,
                }
            )
            bar.advance(1, scene.name)
    return rows


def _random_scenes(study: FieldStudy, bar: ProgressBar) -> list[dict[str, object]]:
    rows: list[dict[str, object]] = []
    for name in study.methods:
        flights: list[FieldFlight] = []
        for seed in study.seeds:
            flights.append(_fly(study, moving_obstacles(seed), name, seed, is_static=False))
            bar.advance(1, name)
        rows.append({"method": name, **_figures(flights)})
    return rows


def _fly(study: FieldStudy, scene: FieldScene, name: str, seed: int, *, is_static: bool) -> FieldFlight:
    method = METHODS[name]
    step_m = STATIC_STEP_M if is_static else study.step_m
    gains = gains_of(method, step_m, STATIC_GAINS if is_static else MOVING_GAINS, literal=study.literal)
    return fly_scene(scene, method, gains, step_m, STATIC_STEPS if is_static else RANDOM_STEPS, seed)


def _figures(flights: Sequence[FieldFlight]) -> dict[str, object]:
    arrived = [one for one in flights if one.arrived]
    low, high = wilson_interval(len(arrived), len(flights)) if flights else (0.0, 1.0)
    return {
        "flights": len(flights),
        "arrived": len(arrived),
        "arrived_ci95": [low, high],
        "collided": sum(collided(one) for one in flights),
        "length_m": float(np.mean([one.length_m for one in arrived])) if arrived else None,
        "turn_max_deg_s": float(np.median([one.turn_max_deg_s for one in arrived])) if arrived else None,
    }


def _as_text(study: FieldStudy, scenes: Sequence[dict[str, object]], random: Sequence[dict[str, object]]) -> str:
    told = [
        [
            str(one["scene"]),
            str(one["method"]),
            str(one["outcome"]),
            str(one["steps"]),
            str(one["escapes"]),
            f"{one['goal_gap_m']:.2f}",
            f"{one['length_m']:.2f}",
        ]
        for one in scenes
    ]
    parts = [
        "The paper's scenes; it prints at most 1000 steps, this goes on to 2000.",
        aligned(SCENE_HEADINGS, told),
        f"Random scenes, {len(study.seeds)}, a step of {study.step_m:g} m; figures of flights that arrived: mean length, median "
        "of the greatest turn between steps of 0.02 s. The printed lengths are shorter than the straight way of the printed "
        "scene (32.9 m), and the printed turn rates have no time step: only trends compare.",
        aligned(RANDOM_HEADINGS, [_row(one) for one in random]),
    ]
    return "\n\n".join(parts)


def _row(one: dict[str, object]) -> list[str]:
    flights, arrived, collisions = one["flights"], one["arrived"], one["collided"]
    interval, length, turn = one["arrived_ci95"], one["length_m"], one["turn_max_deg_s"]
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
        *("-" if value is None else f"{value:.1f}" for value in (length, turn)),
        *(f"{value:.2f}" for value in printed),
    ]

"""All planners in all scenes; a table, pictures of scenes of the paper, and every trial as JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from flightapp.analysis.campaign.output_folder import output_folder
from flightapp.analysis.campaign.progress import ProgressBar
from flightapp.analysis.campaign.statistics import wilson_interval
from flightapp.analysis.campaign.table import aligned
from flightapp.analysis.path_study.picture import scene_picture
from flightapp.analysis.path_study.trial import Trial, run_trial
from flightapp.core.errors import InputError
from flightapp.core.types import Array
from flightapp.planning.path_planning.registry import PATH_PLANNERS
from flightapp.space.random_scene import PAPER_SEEDS, PAPER_WAYS, Scene, random_scene

HEADINGS = (
    "planner",
    "found %",
    "95 %",
    "path m",
    "flight m",
    "detour",
    "clear m",
    "time s",
    "error m",
    "flyable %",
    "planning ms",
    "p99 ms",
)


PAPER, RANDOM = "Scenes of the paper", "Random scenes"


@dataclass(frozen=True, slots=True)
class Study:
    """What is compared. seeds: of random scenes, whose way is one of the paper's three in turn; the paper's nine come first."""

    planners: tuple[str, ...]
    seeds: tuple[int, ...]
    obstacles: int = 17
    iterations: int = 5000
    peers_s: float = 0.1
    """CPU time that OMPL's planners get for each question."""


@dataclass(frozen=True, slots=True)
class Finished:
    folder: Path
    summary: dict[str, object]
    table: str


def installed_planners() -> tuple[str, ...]:
    """All path planners whose package is there."""
    return tuple(name for name in PATH_PLANNERS if not name.startswith("ompl-") or find_spec("ompl") is not None)


def run_study(study: Study, output: Path | None) -> Finished:
    """Every planner on every scene; InputError on names, numbers or a folder that cannot be."""
    for name in study.planners:
        if name not in PATH_PLANNERS:
            raise InputError(f"--planner {name}: no such path planner; known: {', '.join(sorted(PATH_PLANNERS))}")
    if not 0 <= study.obstacles <= 25:
        raise InputError(f"--obstacles {study.obstacles}: must lie between 0 and 25; more do not fit")
    papers = [(seed, _of_the_paper(random_scene(seed, way))) for way in PAPER_WAYS for seed in PAPER_SEEDS]
    ways = list(PAPER_WAYS)
    randoms = [random_scene(seed, ways[k % 3], study.obstacles) for k, seed in enumerate(study.seeds)]
    folder = output_folder(output, "paths")
    trials: list[Trial] = []
    with ProgressBar("paths", len(study.planners) * (len(papers) + len(randoms))) as bar:
        for seed, scene in papers:
            flown: dict[str, Array] = {}
            for name in study.planners:
                trial, flown[name] = run_trial(name, scene, seed, study.iterations, study.peers_s)
                trials.append(trial)
                bar.advance(1, scene.name)
            if seed == PAPER_SEEDS[0]:
                (folder / f"{scene.name}.png").write_bytes(scene_picture(scene, flown))
        for scene, seed in zip(randoms, study.seeds, strict=True):
            for name in study.planners:
                trials.append(run_trial(name, scene, seed, study.iterations, study.peers_s)[0])
                bar.advance(1, scene.name)
    return _written(study, folder, [scene for _, scene in papers], trials)


def _written(study: Study, folder: Path, papers: Sequence[Scene], trials: Sequence[Trial]) -> Finished:
    names = {scene.name for scene in papers}
    groups = {
        PAPER: [one for one in trials if one.scene in names and not one.direct],
        RANDOM: [one for one in trials if one.scene not in names and not one.direct],
    }
    direct = {PAPER: _direct(trials, names), RANDOM: _direct(trials, {one.scene for one in trials} - names)}
    scenes = {PAPER: len(papers), RANDOM: len(study.seeds)}
    figures = {title: {name: _figures(group, name) for name in study.planners} for title, group in groups.items()}
    texts = [
        f"{title}, {scenes[title] - direct[title]} of {scenes[title]}; the others have a free straight way\n{_table(by_planner)}"
        for title, by_planner in figures.items()
    ]
    texts.append(
        f"Medians; clear: smallest, error: greatest. Own planners: {study.iterations} iterations. OMPL's: {study.peers_s:g} s of "
        "CPU time for each question; RRTConnect ends with its first way."
    )
    text = "\n\n".join(texts)
    summary: dict[str, object] = {"study": asdict(study), "direct_scenes": direct, "figures": figures}
    every = {**summary, "trials": [_plain(one) for one in trials]}
    (folder / "trials.json").write_text(json.dumps(every, indent=1) + "\n")
    (folder / "table.md").write_text(text + "\n")
    return Finished(folder, summary, text)


def _of_the_paper(scene: Scene) -> Scene:
    """Told apart from a random scene of the same seed."""
    return replace(scene, name=f"paper-{scene.name}")


def _direct(trials: Sequence[Trial], scenes: set[str]) -> int:
    """In how many of `scenes` the straight way is free."""
    return len({one.scene for one in trials if one.direct and one.scene in scenes})


def _figures(trials: Sequence[Trial], name: str) -> dict[str, float | int | None]:
    own = [one for one in trials if one.planner == name]
    found = [one for one in own if one.found]
    low, high = wilson_interval(len(found), len(own)) if own else (0.0, 1.0)
    planning = [one.planning_s for one in own]
    return {
        "scenes": len(own),
        "found": len(found),
        "found_low": low,
        "found_high": high,
        "path_m": _median([one.path_m for one in found]),
        "length_m": _median([one.length_m for one in found]),
        "detour": _median([one.detour for one in found]),
        "clearance_min_m": min((one.clearance_m for one in found), default=None),
        "duration_s": _median([one.duration_s for one in found]),
        "error_max_m": max((one.error_m for one in found), default=None),
        "flyable": sum(one.flyable for one in own),
        "planning_ms": _median([1e3 * value for value in planning]),
        "planning_p99_ms": None if not planning else float(np.percentile([1e3 * value for value in planning], 99)),
    }


def _table(by_planner: Mapping[str, Mapping[str, float | int | None]]) -> str:
    rows = []
    for name, one in by_planner.items():
        scenes = max(1, int(one["scenes"] or 0))
        interval = f"{100 * (one['found_low'] or 0):.0f}-{100 * (one['found_high'] or 0):.0f}"
        numbers = (
            (one["path_m"], 1),
            (one["length_m"], 1),
            (one["detour"], 3),
            (one["clearance_min_m"], 2),
            (one["duration_s"], 1),
            (one["error_max_m"], 2),
        )
        rows.append(
            [
                name,
                f"{100 * (one['found'] or 0) / scenes:.0f}",
                interval,
                *("-" if value is None else f"{value:.{decimals}f}" for value, decimals in numbers),
                f"{100 * (one['flyable'] or 0) / scenes:.0f}",
                *("-" if one[key] is None else f"{one[key]:.0f}" for key in ("planning_ms", "planning_p99_ms")),
            ]
        )
    return aligned(HEADINGS, rows)


def _median(values: Sequence[float]) -> float | None:
    return float(np.median(values)) if values else None


def _plain(trial: Trial) -> dict[str, object]:
    return {name: None if isinstance(value, float) and math.isnan(value) else value for name, value in asdict(trial).items()}

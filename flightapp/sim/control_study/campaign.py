"""The control study from its question to its answer: every seed of every setting, flown by every method on both plants."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import joblib
from joblib.externals.loky.process_executor import TerminatedWorkerError

from flightapp.analysis.campaign.output_folder import output_folder
from flightapp.analysis.campaign.progress import ProgressBar
from flightapp.analysis.campaign.workers import Workers, flown
from flightapp.analysis.summary import write_whole
from flightapp.core.clock import monotonic_ns
from flightapp.core.errors import FlightError, InputError
from flightapp.sim.control_study.flown import FOLLOWERS, FlownScene, Setting, fly_one, fly_scene
from flightapp.sim.control_study.methods import METHODS, PLANTS, REAL_PLANT
from flightapp.sim.control_study.picture import draw_formation, draw_study, draw_tracking
from flightapp.sim.control_study.printed_tables import SETTINGS
from flightapp.sim.control_study.reference import plan_course
from flightapp.sim.control_study.table import OURS, Acceptance, Row, acceptance, as_markdown, rows_of
from flightapp.space.random_scene import PAPER_WAYS

NAME = "control"
DRAWN = ("hybrid printed", "pid tuned", "px4 default", "hybrid tuned")


@dataclass(frozen=True, slots=True)
class ControlStudy:
    """The question."""

    seeds: tuple[int, ...]
    settings: tuple[Setting, ...] = SETTINGS
    methods: tuple[str, ...] = tuple(METHODS)


@dataclass(frozen=True, slots=True)
class FinishedStudy:
    """The answer; `complete` False where a person ended it early."""

    folder: Path
    scenes: tuple[FlownScene, ...]
    seconds: float
    complete: bool

    @property
    def rows(self) -> list[Row]:
        return rows_of(self.scenes)

    @property
    def acceptance(self) -> Acceptance:
        """On the first setting: the source's own."""
        first = self.scenes[0].setting if self.scenes else ""
        return acceptance([scene for scene in self.scenes if scene.setting == first], REAL_PLANT.name)

    @property
    def summary(self) -> dict[str, object]:
        """What machines get."""
        verdict = self.acceptance
        return {
            "scenes": len(self.scenes),
            "seconds": round(self.seconds, 1),
            "complete": self.complete,
            "acceptance": {"met": verdict.accepted, "share": round(verdict.share, 3), "failed": list(verdict.failed)},
            "unplanned": [{"setting": one.setting, "seed": one.seed, "reason": one.reason} for one in self.scenes if one.reason],
            "rows": [row.as_json() for row in self.rows],
        }


def study_settings(way: str, only_first: bool) -> tuple[Setting, ...]:
    """The settings of table 1 with another start and goal; InputError on an unknown way."""
    if way not in PAPER_WAYS:
        raise InputError(f"--way {way}: no such way; known: {', '.join(PAPER_WAYS)}")
    return tuple(replace(setting, way=way) for setting in (SETTINGS[:1] if only_first else SETTINGS))


def study_methods(labels: Sequence[str]) -> tuple[str, ...]:
    """`labels`, or all; InputError on an unknown one."""
    for label in labels:
        if label not in METHODS:
            raise InputError(f'--method "{label}": no such method; known: {", ".join(map(repr, METHODS))}')
    return tuple(labels) or tuple(METHODS)


def run_control_study(study: ControlStudy, workers: Workers, output: Path | None) -> FinishedStudy:
    """Fly all of it; tables.md, control.json and three pictures go to the folder."""
    folder = output_folder(output, NAME, "--out")
    begun_ns = monotonic_ns()
    scenes: list[FlownScene] = []
    complete = True
    with ProgressBar(NAME, len(study.settings) * len(study.seeds)) as bar:
        try:
            for one in _flown(study, workers):
                scenes.append(one)
                bar.advance(1, f"{sum(not each.reason for each in scenes)} planned")
        except KeyboardInterrupt:
            complete = False
        except TerminatedWorkerError:
            raise FlightError("a worker process died, perhaps for lack of memory; use fewer --workers") from None
    order = {setting.name: place for place, setting in enumerate(study.settings)}
    scenes.sort(key=lambda one: (order[one.setting], one.seed))
    finished = FinishedStudy(folder, tuple(scenes), (monotonic_ns() - begun_ns) * 1e-9, complete)
    _write(study, finished)
    return finished


def _flown(study: ControlStudy, workers: Workers) -> Iterator[FlownScene]:
    tasks = [(setting, seed) for setting in study.settings for seed in study.seeds]
    if workers.expected == 1:
        for setting, seed in tasks:
            yield fly_scene(setting, seed, study.methods, PLANTS)
        return
    yield from flown(workers, [joblib.delayed(fly_scene)(setting, seed, study.methods, PLANTS) for setting, seed in tasks])


def _write(study: ControlStudy, finished: FinishedStudy) -> None:
    told = {
        **finished.summary,
        "flights": [one.as_json() for scene in finished.scenes for one in scene.flights],
    }
    write_whole(finished.folder / "control.json", (json.dumps(told, indent=2) + "\n").encode())
    rows = finished.rows
    if not rows:
        return
    write_whole(finished.folder / "tables.md", as_markdown(rows, finished.acceptance.sentence).encode())
    shown = next(scene for scene in finished.scenes if not scene.reason)
    setting = next(one for one in study.settings if one.name == shown.setting)
    course = plan_course(shown.seed, setting.way, setting.obstacles, setting.step_m, FOLLOWERS)
    assert not isinstance(course, str)
    traces = {name: fly_one(setting, shown.seed, course, METHODS[name], REAL_PLANT)[1] for name in DRAWN if name in study.methods}
    title = f"{setting.name}, {setting.way}, seed {shown.seed}, {REAL_PLANT.name}"
    pictures = {"control": draw_study(traces, course, title), "tracking": draw_tracking(traces, title)}
    if OURS in traces:
        pictures["formation"] = draw_formation(traces[OURS], course, f"{OURS}, seed {shown.seed}")
    for name, picture in pictures.items():
        write_whole(finished.folder / f"{name}.png", picture)

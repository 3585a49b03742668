"""All trials over all cores, then what they come to."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter

import joblib

from flightapp.bench.machine import machine
from flightapp.bench.perception_truth.picture import draw_detection
from flightapp.bench.perception_truth.score import Score, score_trial
from flightapp.bench.perception_truth.summary import Summary, summarise
from flightapp.bench.perception_truth.trials import Trial, all_trials
from flightapp.config.profile import Profile, load_profile
from flightapp.core.errors import InputError

PICTURE = "perception-detection.png"


def run_perception_truth(profile: Path, seed: int = 0, quick: bool = False, out: Path | None = None) -> Summary:
    """Measure the perception of `profile` against known scenes; with `out`, draw the picture into that folder.

    Returns the machine and everything of `summarise`. The same seed gives the same numbers, on however many cores.
    """
    loaded = load_profile(profile)
    if out is not None:
        try:
            out.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"--out = '{out}': cannot be made a folder: {error.strerror}") from None
    about, begin_s = machine(), perf_counter()
    summary = summarise(_scores(all_trials(seed, quick), loaded))
    picture = None
    if out is not None:
        picture = out / PICTURE
        draw_detection(summary["detection"], picture)
    return {
        "machine": about,
        "seed": seed,
        "quick": quick,
        "wall_s": perf_counter() - begin_s,
        "picture": None if picture is None else str(picture),
        **summary,
    }


def _scores(trials: list[Trial], profile: Profile) -> list[Score]:
    """In the order of the trials; neighbours cost alike, so every core gets some of each."""
    cores = int(joblib.cpu_count())
    tasks = (joblib.delayed(score_trial)(trial, profile) for trial in trials)
    return list(joblib.Parallel(n_jobs=cores, batch_size=4)(tasks))

"""How planners close in, over many seeds: median and middle half of the distance to the evader."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flightapp.analysis.campaign.pictures.ground import legend_beside
from flightapp.analysis.campaign.pictures.style import EVADER, new_figure, planner_colour, png
from flightapp.analysis.campaign.seeds import seeds_text
from flightapp.analysis.campaign.trace import Trace
from flightapp.core.types import Array


def convergence_picture(runs: Sequence[Sequence[Trace]]) -> bytes:
    """One line and band a planner; runs: for each planner the same seeds of one scenario."""
    figure = new_figure(9.0, 3.6)
    axes = figure.add_subplot()
    scenario = runs[0][0].scenario
    end_s = max(one.result.duration_s for some in runs for one in some)
    times_s = np.arange(0.0, end_s + scenario.control_period_s, scenario.control_period_s)
    for index, some in enumerate(runs):
        low, middle, high = np.percentile([_distances_m(one, times_s) for one in some], (25.0, 50.0, 75.0), axis=0)
        captured = sum(one.result.outcome == "captured" for one in some)
        label = f"{some[0].result.planner}: {captured} of {len(some)} captured"
        axes.plot(times_s, middle, color=planner_colour(index), linewidth=1.8, label=label)
        axes.fill_between(times_s, low, high, color=planner_colour(index), alpha=0.18, linewidth=0.0)
    radius_m = scenario.capture.radius_m
    axes.axhline(radius_m, color=EVADER, linewidth=1.0, linestyle="--", label=f"capture radius {radius_m:g} m")
    axes.set_xlim(0.0, times_s[-1])
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("time, s")
    axes.set_ylabel("nearest pursuer to evader, m")
    seeds = seeds_text(tuple(one.result.seed for one in runs[0]))
    axes.set_title(f"{scenario.name}, seeds {seeds}: median and middle half; runs that ended keep their last distance")
    axes.grid(True)
    axes.set_axisbelow(True)
    legend_beside(axes)
    return png(figure)


def _distances_m(run: Trace, times_s: Array) -> Array:
    """At `times_s`; after the end, the last one."""
    return np.interp(times_s, run.times_s(), run.distances_m())

"""All planners on one seed: their paths over one another, and how they close in."""

from __future__ import annotations

from collections.abc import Sequence

from flightapp.analysis.campaign.pictures.ground import ground_figure, legend_beside, mark_end
from flightapp.analysis.campaign.pictures.style import EVADER, ending, new_figure, planner_colour, png
from flightapp.analysis.campaign.trace import Trace
from flightapp.analysis.map_data import INK


def paths_picture(traces: Sequence[Trace]) -> bytes:
    """Superposed paths of one seed, one colour a planner; the evader's dotted in the colour of the planner that it fled."""
    figure, axes = ground_figure(traces)
    for index, one in enumerate(traces):
        colour, positions, width = planner_colour(index), one.positions_m(), _width(index, len(traces))
        for pursuer in range(one.pursuers):
            label = f"{one.result.planner}:\n{ending(one.result)}" if pursuer == 0 else None
            axes.plot(positions[:, pursuer, 1], positions[:, pursuer, 0], color=colour, linewidth=width, label=label, zorder=4)
        axes.plot(positions[:, -1, 1], positions[:, -1, 0], ":", color=colour, linewidth=1.6, zorder=3)
        mark_end(axes, one, colour)
    axes.plot([], [], ":", color=INK, linewidth=1.6, label="evader")
    if any(one.result.outcome == "captured" for one in traces):
        axes.plot([], [], "*", color=INK, markersize=9, label="capture")
    if any(one.result.outcome == "collided" for one in traces):
        axes.plot([], [], "x", color=INK, markersize=7, markeredgewidth=2, label="collision")
    axes.set_title(f"{traces[0].scenario.name}, seed {traces[0].result.seed}")
    legend_beside(axes)
    return png(figure)


def distance_picture(traces: Sequence[Trace]) -> bytes:
    """Distance from the evader to the nearest pursuer over time, one line a planner."""
    figure = new_figure(9.0, 3.6)
    axes = figure.add_subplot()
    for index, one in enumerate(traces):
        label = f"{one.result.planner}: {ending(one.result)}"
        axes.plot(
            one.times_s(), one.distances_m(), color=planner_colour(index), linewidth=_width(index, len(traces)), label=label
        )
    radius_m = traces[0].scenario.capture.radius_m
    axes.axhline(radius_m, color=EVADER, linewidth=1.0, linestyle="--", label=f"capture radius {radius_m:g} m")
    axes.set_xlim(left=0.0)
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("time, s")
    axes.set_ylabel("nearest pursuer to evader, m")
    axes.set_title(f"{traces[0].scenario.name}, seed {traces[0].result.seed}")
    axes.grid(True)
    axes.set_axisbelow(True)
    legend_beside(axes)
    return png(figure)


def _width(index: int, count: int) -> float:
    """Later lines are thinner: one that covers another leaves its edges to be seen."""
    return 1.4 + 0.5 * (count - 1 - index)

"""Figures of several planners against a quantity that differs between scenarios, such as the number of obstacles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from flightapp.analysis.campaign.pictures.ground import legend_beside
from flightapp.analysis.campaign.pictures.style import new_figure, planner_colour, png


@dataclass(frozen=True, slots=True)
class Panel:
    """One of the axes. `middle`: the name of the figure that is drawn as a line; `low`, `high`: of a band or thin lines."""

    y_label: str
    middle: str
    low: str | None = None
    high: str | None = None
    factor: float = 1.0
    top: float | None = None


def against_picture(
    title: str,
    x_label: str,
    panels: Sequence[Panel],
    planners: Mapping[str, Sequence[tuple[float, Mapping[str, float | None]]]],
) -> bytes:
    """One panel beside the other, a line a planner; planners: (x, its figures there), x ascending. What is None is left out."""
    figure = new_figure(11.0, 3.4)
    grid = figure.subplots(1, len(panels), squeeze=False)[0]
    for axes, panel in zip(grid, panels, strict=True):
        for index, (planner, points) in enumerate(planners.items()):
            colour, width = planner_colour(index), 1.4 + 0.8 * (len(planners) - 1 - index)  # of those in one place all are seen
            axes.plot(
                *_line(points, panel.middle, panel.factor), "o-", color=colour, linewidth=width, markersize=3.5, label=planner
            )
            if panel.low is not None and panel.high is not None:
                x, low = _line(points, panel.low, panel.factor)
                axes.fill_between(x, low, _line(points, panel.high, panel.factor)[1], color=colour, alpha=0.12, linewidth=0.0)
            elif panel.low is not None:
                axes.plot(*_line(points, panel.low, panel.factor), ":", color=colour, linewidth=1.4)
        axes.set_ylim(0.0, panel.top)
        axes.set_xlabel(x_label)
        axes.set_ylabel(panel.y_label)
        axes.grid(True)
        axes.set_axisbelow(True)
    legend_beside(grid[-1])
    figure.suptitle(title, fontsize=10)
    return png(figure)


def _line(
    points: Sequence[tuple[float, Mapping[str, float | None]]], name: str, factor: float
) -> tuple[list[float], list[float]]:
    known = [(x, factor * value) for x, figures in points if (value := figures[name]) is not None]
    return [x for x, _ in known], [y for _, y in known]

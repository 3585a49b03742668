"""Success, capture time, separation and state age against delay, a line for each loss; partitions as marks of their own."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from matplotlib.axes import Axes

from flightapp.analysis.campaign.pictures.style import new_figure, planner_colour, png
from flightapp.sim.network_campaign.table import Row

MARKERS = {"none": "o", "one": "x", "halves": "s"}
NAMES = {"none": "whole network", "one": "one cut off for 6 s", "halves": "halves for 6 s"}


def draw_campaign(rows: Sequence[Row]) -> bytes:
    """PNG."""
    figure = new_figure(9.5, 6.4)
    axes = figure.subplots(2, 2, sharex=True)
    _panel(axes[0, 0], rows, "captured, %", lambda row: 100.0 * row.captured / row.missions, intervals=True)
    _panel(axes[0, 1], rows, "median time to capture, s", lambda row: row.capture_time_s)
    _panel(axes[1, 0], rows, "smallest separation of pursuers, m", lambda row: row.separation_min_m)
    _panel(axes[1, 1], rows, "age of teammates' states, p99, ms", lambda row: row.age_p99_ms)
    for panel in axes[1]:
        panel.set_xlabel("delay of a packet (+- half of it), ms")
    axes[0, 0].set_ylim(-4.0, 104.0)
    for panel in (axes[0, 1], axes[1, 0]):
        panel.set_ylim(bottom=0.0)
    axes[1, 1].set_yscale("log")  # seconds while the network is split, else tenths
    axes[1, 1].legend(loc="best")
    figure.suptitle(f"Pursuit over a bad network, {sum(row.missions for row in rows)} missions on the virtual clock")
    return png(figure)


def _panel(
    panel: Axes, rows: Sequence[Row], title: str, value: Callable[[Row], float | None], *, intervals: bool = False
) -> None:
    losses = sorted({row.loss_percent for row in rows})
    for partition in MARKERS:
        for index, loss in enumerate(losses):
            line = [row for row in rows if (row.partition, row.loss_percent) == (partition, loss) and value(row) is not None]
            if line:
                _line(panel, line, [value(row) or 0.0 for row in line], f"{NAMES[partition]}, {loss:g} % lost", index)
                if intervals and partition == "none":
                    low, high = ([100.0 * getattr(row, f"captured_{end}") for row in line] for end in ("low", "high"))
                    panel.fill_between([row.delay_ms for row in line], low, high, color=planner_colour(index), alpha=0.08, lw=0)
    panel.set_title(title)
    panel.grid(visible=True)


def _line(panel: Axes, line: Sequence[Row], values: Sequence[float], label: str, index: int) -> None:
    partition = line[0].partition
    style = "-" if partition == "none" else ":"
    panel.plot([row.delay_ms for row in line], values, style, marker=MARKERS[partition], color=planner_colour(index), label=label)

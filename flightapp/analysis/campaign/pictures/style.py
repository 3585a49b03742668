"""One look for all pictures: size, colours, words."""

from __future__ import annotations

import io
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from flightapp.analysis.map_data import EVADER_COLOUR, INK
from flightapp.sim.batch.result import RunResult

DPI = 160
PLANNER_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#aa4499", "#e69f00", "#56b4e9", "#5f6c7b", "#8c6d1f")
"""Told apart by most colour-blind people (Okabe and Ito), in the order of the campaign's planners."""
MODE_COLOURS = {"coarse": "#0072b2", "fine": "#e69f00", "tracking": "#009e73", "search": "#aa4499", "hold": "#5f6c7b"}
OTHER_MODE_COLOURS = ("#56b4e9", "#8c6d1f", "#d55e00")
GRID, STONE, BOUNDARY = "#e4e7eb", "#9aa5b1", "#b42318"
EVADER = EVADER_COLOUR
_OUTCOMES = {"captured": "captured", "collided": "collided", "escaped": "evader escaped", "timed_out": "timed out"}
_RC: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.edgecolor": STONE,
    "axes.labelcolor": INK,
    "axes.titlesize": 10,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "grid.color": GRID,
    "grid.linewidth": 0.8,
    "legend.frameon": False,
    "legend.fontsize": 8,
}


def new_figure(width_in: float, height_in: float) -> Figure:
    """An empty figure of this house's look, independent of a person's own settings."""
    mpl.rcdefaults()
    mpl.rcParams.update(_RC)
    return Figure(figsize=(width_in, height_in), dpi=DPI, layout=ConstrainedLayoutEngine(wspace=0.08))


def png(figure: Figure) -> bytes:
    """The picture as a file."""
    sink = io.BytesIO()
    figure.savefig(sink, format="png", bbox_inches="tight", pad_inches=0.08)
    return sink.getvalue()


def planner_colour(index: int) -> str:
    return PLANNER_COLOURS[index % len(PLANNER_COLOURS)]


def ending(result: RunResult) -> str:
    """How a run ended, in words."""
    with_what = f" with {_with_article(result.collided_with)}" if result.collided_with else ""
    return f"{_OUTCOMES[result.outcome]}{with_what} after {result.duration_s:.1f} s"


def _with_article(thing: str) -> str:
    return f"an {thing}" if thing[0] in "aeiou" else f"a {thing}"

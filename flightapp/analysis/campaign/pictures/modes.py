"""One run, the pursuers' paths in the colours of their modes."""

from __future__ import annotations

import itertools

import numpy as np
from matplotlib.axes import Axes

from flightapp.analysis.campaign.pictures.ground import ground_figure, legend_beside, mark_end
from flightapp.analysis.campaign.pictures.style import EVADER, MODE_COLOURS, OTHER_MODE_COLOURS, ending, png
from flightapp.analysis.campaign.trace import Trace
from flightapp.analysis.map_data import INK
from flightapp.core.types import Array

TICK_S = 2.0


def modes_picture(trace: Trace) -> bytes:
    """Paths by mode, a dot every `TICK_S` on every path so that simultaneous places can be told."""
    figure, axes = ground_figure([trace])
    positions, times = trace.positions_m(), trace.times_s()
    colours = _colours(sorted({mode for pursuer in range(trace.pursuers) for mode in trace.modes(pursuer)}))
    for pursuer in range(trace.pursuers):
        _stretches(axes, positions[:, pursuer], trace.modes(pursuer), colours)
    for mode, colour in colours.items():
        axes.plot([], [], color=colour, linewidth=2.2, label=mode)
    axes.plot(positions[:, -1, 1], positions[:, -1, 0], ":", color=EVADER, linewidth=1.8, label="evader", zorder=3)
    ticks = np.arange(TICK_S, times[-1], TICK_S)
    for vehicle in range(trace.pursuers + 1):
        north, east = (np.interp(ticks, times, positions[:, vehicle, axis]) for axis in (0, 1))
        label = f"every {TICK_S:g} s" if vehicle == 0 else None
        colour = EVADER if vehicle == trace.pursuers else INK
        axes.plot(east, north, "o", color=colour, markersize=2.4, zorder=5, label=label)
    mark_end(axes, trace, EVADER if trace.result.outcome == "captured" else INK)
    if trace.result.outcome == "captured":
        axes.plot([], [], "*", color=EVADER, markersize=9, label="capture")
    elif trace.result.outcome == "collided":
        axes.plot([], [], "x", color=INK, markersize=7, markeredgewidth=2, label="collision")
    axes.set_title(f"{trace.scenario.name}, seed {trace.result.seed}\n{trace.result.planner}: {ending(trace.result)}")
    legend_beside(axes)
    return png(figure)


def _colours(modes: list[str]) -> dict[str, str]:
    """A colour for each mode: the same in every picture for those of AC2F."""
    others = itertools.cycle(OTHER_MODE_COLOURS)
    known = [mode for mode in MODE_COLOURS if mode in modes]
    return {mode: MODE_COLOURS.get(mode) or next(others) for mode in [*known, *(m for m in modes if m not in known)]}


def _stretches(axes: Axes, path_m: Array, modes: list[str], colours: dict[str, str]) -> None:
    """One line from each change of mode to the next."""
    changes = [0, *(i for i in range(1, len(modes)) if modes[i] != modes[i - 1]), len(modes)]
    for first, last in itertools.pairwise(changes):
        part = path_m[first : last + 1]
        axes.plot(part[:, 1], part[:, 0], color=colours[modes[first]], linewidth=2.0, zorder=4)

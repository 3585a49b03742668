"""The world under the paths: equal axes, obstacles, boundary, starts. East to the right, north up, metres."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Patch, Polygon
from shapely.geometry import LineString, box

from flightapp.analysis.campaign.pictures.style import BOUNDARY, EVADER, STONE, new_figure
from flightapp.analysis.campaign.trace import Trace
from flightapp.analysis.map_data import INK
from flightapp.core.types import Array
from flightapp.planning.plane import nearest_on, segments
from flightapp.sim.batch.families.layout import Layout
from flightapp.sim.batch.walls import edge_rows, wall_distance_m

LONG_SIDE_IN, LEGEND_IN, MARGIN_IN = 6.4, 2.3, 0.7
SHORT_SIDE_MIN_IN = 3.0
ROOM_M, ROOM_SHARE = 1.0, 0.03
BOUNDARY_SHOWN_SHARE = 0.35
"""The view grows by at most this share of its own size to show the boundary."""


def ground_figure(traces: Sequence[Trace]) -> tuple[Figure, Axes]:
    """A figure of the world of `traces` (same scenario and seed) that shows all of their paths, with room for a legend."""
    layout = traces[0].layout
    low, high = _view(layout, np.concatenate([one.positions_m().reshape(-1, 2) for one in traces]))
    height, width = high - low
    scale = LONG_SIDE_IN / max(height, width)
    figure = new_figure(
        max(width * scale, SHORT_SIDE_MIN_IN) + LEGEND_IN + MARGIN_IN, max(height * scale, SHORT_SIDE_MIN_IN) + MARGIN_IN
    )
    axes = figure.add_subplot()
    axes.set_aspect("equal")
    axes.set_xlim(low[1], high[1])
    axes.set_ylim(low[0], high[0])
    axes.set_xlabel("east, m")
    axes.set_ylabel("north, m")
    axes.grid(True)
    axes.set_axisbelow(True)
    _draw_layout(axes, layout)
    return figure, axes


def legend_beside(axes: Axes) -> None:
    """The legend to the right of the axes, where it hides nothing."""
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0)


def _view(layout: Layout, paths_m: Array) -> tuple[Array, Array]:
    """Corners (north, east) of what is worth showing: paths and obstacles, and the boundary where it is near."""
    shown = np.concatenate([paths_m, layout.discs[:, :2] - layout.discs[:, 2:3], layout.discs[:, :2] + layout.discs[:, 2:3]])
    low, high = shown.min(axis=0), shown.max(axis=0)
    middle = (float((low + high)[0] / 2.0), float((low + high)[1] / 2.0))
    nearest = np.array(nearest_on(middle, segments(layout.boundary))[:2])
    if (np.maximum(low - nearest, nearest - high) <= BOUNDARY_SHOWN_SHARE * max(high - low)).all():
        low, high = np.minimum(low, nearest), np.maximum(high, nearest)
    room = ROOM_M + ROOM_SHARE * max(high - low)
    return low - room, high + room


def _draw_layout(axes: Axes, layout: Layout) -> None:
    solid: list[Patch] = [Circle((east, north), radius) for north, east, radius in layout.discs[:, :3]]
    solid += [Polygon(corners[:, ::-1]) for corners in layout.polygons]
    axes.add_collection(PatchCollection(solid, facecolor=STONE, edgecolor="#52606d", linewidth=0.6, alpha=0.55, zorder=1.5))
    moving = layout.discs[(layout.discs[:, 3:5] != 0.0).any(axis=1)]
    if len(moving):
        axes.quiver(moving[:, 1], moving[:, 0], moving[:, 4], moving[:, 3], angles="xy", scale_units="xy", scale=1.0, width=0.003)
    vertices = layout.boundary.vertices_m
    line = np.concatenate([vertices, vertices[:1]]) if layout.boundary.closed else vertices
    (north_low, north_high), (east_low, east_high) = sorted(axes.get_ylim()), sorted(axes.get_xlim())
    seen = box(east_low, north_low, east_high, north_high).intersects(LineString(line[:, ::-1]))
    label = "protected boundary" if seen else None
    axes.plot(line[:, 1], line[:, 0], color=BOUNDARY, linewidth=2.2, label=label, zorder=2)
    starts = np.array([[start.north_m, start.east_m] for start in layout.pursuers])
    whose = "pursuer's start" if len(starts) == 1 else "pursuers' starts"
    axes.plot(starts[:, 1], starts[:, 0], "o", color=INK, markersize=5, label=whose, zorder=6)
    axes.plot(layout.evader.east_m, layout.evader.north_m, "s", color=EVADER, markersize=5, label="evader's start", zorder=6)


def mark_end(axes: Axes, trace: Trace, colour: str) -> None:
    """A star where the evader was captured, a cross where pursuers collided."""
    end = trace.positions_m()[-1]
    if trace.result.outcome == "captured":
        axes.plot(
            end[-1, 1], end[-1, 0], "*", color=colour, markeredgecolor="white", markeredgewidth=0.7, markersize=13, zorder=7
        )
    elif trace.result.outcome == "collided":
        collided = _collided(trace)
        axes.plot(end[collided, 1], end[collided, 0], "x", color=colour, markersize=9, markeredgewidth=2.2, zorder=7)


def _collided(trace: Trace) -> int:
    """The pursuer that is nearest to what it can have hit at the end."""
    end = trace.positions_m()[-1]
    discs, last = trace.layout.discs, trace.periods[-1]
    gaps = []
    for pursuer in range(trace.pursuers):
        others = [np.linalg.norm(end[pursuer] - end[other]) for other in range(trace.pursuers) if other != pursuer]
        centres = discs[:, :2] + discs[:, 3:5] * last.t_s
        to_discs = np.linalg.norm(centres - end[pursuer], axis=1) - discs[:, 2]
        to_walls = [wall_distance_m(*end[pursuer].tolist(), *edge) for edge in edge_rows(trace.layout.polygons).tolist()]
        gaps.append(min([*to_discs, *to_walls, *others] if trace.result.collided_with == "obstacle" else others, default=np.inf))
    return int(np.argmin(gaps))

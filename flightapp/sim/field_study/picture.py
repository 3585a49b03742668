"""The paper's three scenes with the ways of all methods, from above and from the side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.patches import Circle

from flightapp.analysis.campaign.pictures.style import GRID, STONE, new_figure, planner_colour, png
from flightapp.planning.adaptive_apf.paper_step import STEP_S
from flightapp.sim.field_study.flight import FieldFlight
from flightapp.sim.field_study.scenes import PERIOD, FieldScene
from flightapp.space.bodies import BOTTOM, EAST, LENGTH, NORTH, TOP, V_DOWN, V_EAST, V_NORTH

ENDS = {"arrived": "", "collided": "x", "did not arrive": "s"}


def scenes_picture(scenes: Sequence[FieldScene], flown: Mapping[str, Sequence[FieldFlight]]) -> bytes:
    """PNG. flown: by method, a flight for every scene. A cross ends a collision, a square what did not arrive."""
    figure = new_figure(3.4 * len(scenes), 6.6)
    rows = figure.subplots(2, len(scenes), squeeze=False)
    for column, scene in enumerate(scenes):
        above, beside = rows[0][column], rows[1][column]
        above.set(title=scene.name, xlabel="east, m", ylabel="north, m")
        beside.set(xlabel="north, m", ylabel="height, m")
        _draw_bodies(above, scene, EAST, NORTH, V_EAST, V_NORTH)
        _draw_bodies(beside, scene, NORTH, TOP, V_NORTH, V_DOWN)
        for index, (name, flights) in enumerate(flown.items()):
            flight, colour = flights[column], planner_colour(index)
            north, east, height = flight.places_ned_m[:, 0], flight.places_ned_m[:, 1], -flight.places_ned_m[:, 2]
            mark = ENDS[flight.outcome]
            for axes, x, y in ((above, east, north), (beside, north, height)):
                axes.plot(x, y, color=colour, linewidth=1.1, label=name)
                if mark:
                    axes.plot(x[-1], y[-1], mark, color=colour, markersize=6)
        for axes, across, up, sign in ((above, 1, 0, 1.0), (beside, 0, 2, -1.0)):
            for place, symbol in ((scene.start_ned_m, "o"), (scene.goal_ned_m, "*")):
                axes.plot(place[across], sign * place[up], symbol, color="#111827", markersize=7)
            axes.set(aspect="equal", adjustable="datalim")
            axes.grid(color=GRID)
    figure.legend(*rows[0][0].get_legend_handles_labels(), loc="outside lower center", ncols=len(flown))
    return png(figure)


def _draw_bodies(axes: Any, scene: FieldScene, across: int, up: int, v_across: int, v_up: int) -> None:
    """Where they are at the start; an arrow to where a moving one turns."""
    for body in scene.bodies:
        radius = max(float(body[LENGTH]), 0.08)
        x, y = float(body[across]), float(body[up])
        dx, dy = PERIOD * STEP_S * np.array((body[v_across], body[v_up]))
        if up == TOP:
            y, dy = -0.5 * float(body[TOP] + body[BOTTOM]), -dy
        axes.add_patch(Circle((x, y), radius, facecolor=STONE, alpha=0.55))
        if dx or dy:
            axes.add_patch(Circle((x + dx, y + dy), radius, edgecolor=STONE, fill=False, linestyle=":"))
            axes.annotate("", (x + dx, y + dy), (x, y), arrowprops={"arrowstyle": "->", "color": STONE})

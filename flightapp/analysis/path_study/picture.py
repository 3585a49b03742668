"""A scene and the ways that were found, from above and from the side."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.patches import Circle, Rectangle

from flightapp.analysis.campaign.pictures.style import GRID, STONE, new_figure, planner_colour, png
from flightapp.core.types import Array
from flightapp.space.random_scene import Scene
from flightapp.space.shapes import Cylinder, OrientedBox, Shape


def scene_picture(scene: Scene, flown: Mapping[str, Array]) -> bytes:
    """PNG: plan view, and height over the way."""
    figure = new_figure(11.0, 5.6)
    above, beside = figure.subplots(1, 2, width_ratios=(1.0, 1.15))
    _draw_plan(above, scene, flown)
    _draw_heights(beside, scene, flown)
    figure.suptitle(f"{scene.name}: ways that can be flown, 2.25 m clear of every obstacle")
    return png(figure)


def _draw_plan(axes: Any, scene: Scene, flown: Mapping[str, Array]) -> None:
    for shape in scene.shapes:
        axes.add_patch(_outline(shape))
        axes.annotate(f"{-_top(shape):.0f}", (_place(shape)[1], _place(shape)[0]), ha="center", va="center", fontsize=7)
    for index, way in enumerate(flown.values()):
        if len(way):
            axes.plot(way[:, 1], way[:, 0], color=planner_colour(index), linewidth=1.3)
    axes.plot(*scene.start_ned_m[1::-1], "o", color="#111827", markersize=6)
    axes.plot(*scene.goal_ned_m[1::-1], "*", color="#111827", markersize=11)
    axes.set(xlim=(scene.low_ned_m[1] - 3, scene.high_ned_m[1] + 3), ylim=(scene.low_ned_m[0] - 3, scene.high_ned_m[0] + 3))
    axes.set(aspect="equal", xlabel="east, m", ylabel="north, m", title="from above; numbers: height of the obstacle in m")
    axes.grid(color=GRID)


def _draw_heights(axes: Any, scene: Scene, flown: Mapping[str, Array]) -> None:
    for index, (name, way) in enumerate(flown.items()):
        if not len(way):
            axes.plot([], [], color=planner_colour(index), label=f"{name}: none")
            continue
        along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(way, axis=0), axis=1))))
        axes.plot(along, -way[:, 2], color=planner_colour(index), linewidth=1.3, label=f"{name}: {along[-1]:.1f} m")
    axes.set(xlabel="along the way, m", ylabel="height, m", title="height over the way", ylim=(-2, -scene.low_ned_m[2] + 4))
    axes.grid(color=GRID)
    axes.legend(loc="best")


def _outline(shape: Shape) -> Any:
    if isinstance(shape, OrientedBox):
        corner = (shape.east_m - 0.5 * shape.width_m, shape.north_m - 0.5 * shape.length_m)
        turn = -math.degrees(shape.heading_rad)  # clockwise, drawn with north up and east to the right
        about = (shape.east_m, shape.north_m)
        return Rectangle(corner, shape.width_m, shape.length_m, angle=turn, rotation_point=about, facecolor=STONE, alpha=0.55)
    return Circle((shape.east_m, shape.north_m), shape.radius_m, facecolor=STONE, alpha=0.55)


def _place(shape: Shape) -> tuple[float, float]:
    return shape.north_m, shape.east_m


def _top(shape: Shape) -> float:
    return shape.top_down_m if isinstance(shape, Cylinder | OrientedBox) else 0.0

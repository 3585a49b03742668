"""Figures 6 to 18 of the source from one scene: errors, distances, sliding variable over time, the formation from above."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flightapp.core.types import Array
from flightapp.sim.control_study.reference import Course
from flightapp.sim.control_study.trace import error_of, lyapunov_of, places_of, sliding_of
from flightapp.space.distance import signed_distance

SHOWN_MAX_M = 15.0
SHOWN_EVERY_ROWS = 150
"""Of the trace: so often the vehicles are joined to show their formation."""
LINE, THIN = 1.0, 0.6


def draw_study(traces: Mapping[str, Array], course: Course, title: str) -> bytes:
    """PNG. traces: by method, the leader's (k, PLACES_FROM + 3 n) and the formation's distances."""
    figure = Figure(figsize=(11.0, 14.0), layout="constrained")
    figure.suptitle(title)
    axes = figure.subplots(6, 2)
    _way(axes[0, 0], course)
    for name, trace in traces.items():
        axes[0, 0].plot(trace[:, 5], trace[:, 4], label=name, linewidth=LINE)
    axes[0, 0].set_title("The leader's way, its followers' places in grey (figs. 13 to 15)", fontsize="medium")
    _over_time(axes[0, 1], "Tracking error (figs. 6 to 8, 17), m", traces, error_of, (0.0, SHOWN_MAX_M))
    for place, (column, name) in zip(
        (axes[1, 0], axes[1, 1], axes[2, 0]), ((10, "north"), (11, "east"), (12, "down")), strict=True
    ):
        _over_time(place, f"Error {name} (fig. 16), m", traces, _column(column), (-SHOWN_MAX_M, SHOWN_MAX_M))
    _over_time(axes[2, 1], "Command, m/s^2", traces, lambda t: np.linalg.norm(t[:, 16:19], axis=1))
    _over_time(axes[3, 0], "Mean distance of a pair (figs. 9, 10), m", traces, _column(22))
    _over_time(axes[3, 1], "Smallest distance of a pair, m", traces, _column(23))
    _over_time(axes[4, 0], "Followers off their places (figs. 11, 12), m", traces, _column(24))
    _over_time(axes[4, 1], "|s| = |rate + 35 error| (fig. 18), m/s", traces, sliding_of)
    _over_time(axes[5, 0], "V = (error^2 + rate^2) / 2 (fig. 18)", traces, lyapunov_of)
    axes[5, 0].set_yscale("log")
    axes[4, 1].set_yscale("log")
    axes[5, 1].axis("off")
    axes[0, 1].legend(fontsize="small")
    return _png(figure)


def draw_tracking(traces: Mapping[str, Array], title: str) -> bytes:
    """PNG: the leader's error over time, of every method."""
    figure = Figure(figsize=(7.0, 3.0), layout="constrained")
    axis = figure.subplots()
    _over_time(axis, title, traces, error_of)
    axis.set_yscale("log")
    axis.set_ylabel("error, m")
    axis.legend(fontsize="small")
    return _png(figure)


def draw_formation(trace: Array, course: Course, title: str) -> bytes:
    """PNG: where every vehicle of one flight flew, from above, joined every few seconds."""
    figure = Figure(figsize=(6.0, 6.0), layout="constrained")
    axis = figure.subplots()
    _way(axis, course)
    places = places_of(trace)
    for i in range(places.shape[1]):
        axis.plot(places[:, i, 1], places[:, i, 0], linewidth=LINE, label="leader" if i == 0 else f"follower {i}")
    for row in range(0, len(places), SHOWN_EVERY_ROWS):
        for side in ((0, 1, 3), (0, 2, 4)):
            joined = places[row, [i for i in side if i < places.shape[1]]]
            axis.plot(joined[:, 1], joined[:, 0], color="0.3", linewidth=THIN, marker=".", markersize=3.0)
    axis.set_title(title, fontsize="medium")
    axis.legend(fontsize="small", loc="lower right")
    return _png(figure)


def _png(figure: Figure) -> bytes:
    sink = io.BytesIO()
    figure.savefig(sink, format="png", dpi=80)
    return sink.getvalue()


def _over_time(
    axis: Axes,
    title: str,
    traces: Mapping[str, Array],
    value: Callable[[Array], Array],
    shown: tuple[float, float] | None = None,
) -> None:
    for name, trace in traces.items():
        axis.plot(trace[:, 0], value(trace), label=name, linewidth=LINE)
    axis.set_title(title, fontsize="medium")
    axis.set_xlabel("s")
    if shown is not None:
        axis.set_ylim(*shown)


def _column(number: int) -> Callable[[Array], Array]:
    return lambda trace: trace[:, number]


def _way(axis: Axes, course: Course) -> None:
    """From above: what stands around, and in grey what the followers are asked for."""
    north, east = np.meshgrid(np.linspace(0.0, 100.0, 201), np.linspace(0.0, 100.0, 201), indexing="ij")
    axis.contourf(east, north, _inside(course.bodies, north, east), levels=(0.5, 1.5), colors=["0.8"])
    for one in course.references[1:]:
        axis.plot(one[:, 1], one[:, 0], color="0.6", linewidth=THIN)
    axis.set_xlim(-15.0, 115.0)
    axis.set_ylim(-15.0, 115.0)
    axis.set_aspect("equal")
    axis.set_xlabel("east, m")
    axis.set_ylabel("north, m")


def _inside(bodies: Array, north: Array, east: Array) -> Array:
    """1 where a body stands on the ground."""
    flat = [signed_distance(bodies, float(n), float(e), -1.0, 0.0) < 0.0 for n, e in zip(north.flat, east.flat, strict=True)]
    return np.array(flat, dtype=np.float64).reshape(north.shape)

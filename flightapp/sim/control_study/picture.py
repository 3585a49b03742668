"""Figures 6 to 18 of the source as one picture: errors, distances and the sliding variable of one scene over time."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flightapp.core.types import Array
from flightapp.sim.control_study.reference import Course
from flightapp.space.distance import signed_distance

SLOPE_1_S = 35.0
SHOWN_MAX_M = 15.0


def draw_study(traces: Mapping[str, Array], course: Course, title: str) -> bytes:
    """PNG. traces: by method, the leader's (k, TRACE_COLUMNS) and the formation's distances."""
    figure = Figure(figsize=(13.0, 15.0), layout="constrained")
    figure.suptitle(title)
    axes = figure.subplots(5, 2)
    _way(axes[0, 0], traces, course)
    _over_time(axes[0, 1], "Tracking error (figs. 6 to 8, 17), m", traces, lambda t: _length(t[:, 10:13]), (0.0, SHOWN_MAX_M))
    for place, (column, name) in zip(
        (axes[1, 0], axes[1, 1], axes[2, 0]), ((10, "north"), (11, "east"), (12, "down")), strict=True
    ):
        _over_time(place, f"Error {name} (fig. 16), m", traces, _column(column), (-SHOWN_MAX_M, SHOWN_MAX_M))
    _over_time(axes[2, 1], "Command, m/s^2", traces, lambda t: _length(t[:, 16:19]))
    _over_time(axes[3, 0], "Mean distance of a pair (figs. 9, 10), m", traces, _column(22))
    _over_time(axes[3, 1], "Smallest distance of a pair, m", traces, _column(23))
    _over_time(axes[4, 0], "Followers off their places (figs. 11, 12), m", traces, _column(24))
    printed = {name: trace for name, trace in traces.items() if "printed" in name}
    _over_time(axes[4, 1], "|s| of the printed gains: |rate + 35 error| (fig. 18), m/s", printed, _sliding)
    axes[0, 1].legend(fontsize="small")
    sink = io.BytesIO()
    figure.savefig(sink, format="png", dpi=90)
    return sink.getvalue()


def _over_time(
    axis: Axes,
    title: str,
    traces: Mapping[str, Array],
    value: Callable[[Array], Array],
    shown: tuple[float, float] | None = None,
) -> None:
    for name, trace in traces.items():
        axis.plot(trace[:, 0], value(trace), label=name, linewidth=1.0)
    axis.set_title(title, fontsize="medium")
    axis.set_xlabel("s")
    if shown is not None:
        axis.set_ylim(*shown)


def _column(number: int) -> Callable[[Array], Array]:
    return lambda trace: trace[:, number]


def _length(vectors: Array) -> Array:
    return np.asarray(np.linalg.norm(vectors, axis=1), dtype=np.float64)


def _sliding(trace: Array) -> Array:
    return _length(trace[:, 13:16] + SLOPE_1_S * trace[:, 10:13])


def _way(axis: Axes, traces: Mapping[str, Array], course: Course) -> None:
    """From above (figs. 13 to 15)."""
    north, east = np.meshgrid(np.linspace(0.0, 100.0, 201), np.linspace(0.0, 100.0, 201), indexing="ij")
    axis.contourf(east, north, _inside(course.bodies, north, east), levels=(0.5, 1.5), colors=["0.8"])
    for one in course.references[1:]:
        axis.plot(one[:, 1], one[:, 0], color="0.6", linewidth=0.6)
    for name, trace in traces.items():
        axis.plot(trace[:, 5], trace[:, 4], label=name, linewidth=1.0)
    axis.set_title("The leader's way, and its followers' places in grey (figs. 13 to 15)", fontsize="medium")
    axis.set_xlim(-5.0, 105.0)
    axis.set_ylim(-5.0, 105.0)
    axis.set_aspect("equal")
    axis.set_xlabel("east, m")
    axis.set_ylabel("north, m")


def _inside(bodies: Array, north: Array, east: Array) -> Array:
    """1 where a body stands on the ground."""
    flat = [signed_distance(bodies, float(n), float(e), -1.0, 0.0) < 0.0 for n, e in zip(north.flat, east.flat, strict=True)]
    return np.array(flat, dtype=np.float64).reshape(north.shape)

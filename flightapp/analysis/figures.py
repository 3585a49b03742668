"""The report's charts over time as plotly.js specifications (plain dicts). Colours of paper and ink are the page's."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flightapp.analysis.map_data import EVADER_COLOUR, origin_name, origin_s, vehicle_colours
from flightapp.analysis.outcome import captured_s
from flightapp.analysis.packed import packed, thinned
from flightapp.analysis.run import Run
from flightapp.analysis.signals import Signal
from flightapp.core.types import Array

Figure = dict[str, Any]
_FONT = {"family": "system-ui, -apple-system, 'Segoe UI', Roboto, Arial, sans-serif", "size": 13}
_RED = "#d0453a"
_LEGEND_PX = 460
"""Width of a chart that its legend may use."""
_POINTS_MAX = 1200
"""Of a line: about twice the pixels that a chart is wide."""
_CLEARANCE_SHOWN_M = 6.0
_DASHES = ("solid", "dot", "dash", "dashdot")


@dataclass(frozen=True, slots=True)
class Chart:
    """What is drawn together: quantities in the order of their lines."""

    title: str
    unit: str
    quantities: tuple[str, ...]
    markers: bool = False
    from_zero: bool = True
    shown_max: float | None = None


CHARTS = (
    Chart("Distance to the evader", "m", ("distance_to_evader",)),
    Chart("Separation of the pursuers", "m", ("separation",)),
    Chart("Speed over ground", "m/s", ("speed",)),
    Chart("Jerk", "m/s³", ("jerk",)),
    Chart("Height above the datum", "m", ("height",)),
    Chart("Clearance to obstacles", "m", ("clearance",), shown_max=_CLEARANCE_SHOWN_M),
    Chart("Error of the target estimate, and its own 2 σ", "m", ("target_error",)),
    Chart("Age of the target estimate", "s", ("target_age",)),
    Chart("Planner step", "ms", ("planner_latency",), markers=True),
    Chart("Perception of a frame", "ms", ("perception_latency",), markers=True),
    Chart("Frame to setpoint", "ms", ("frame_to_setpoint",), markers=True),
    Chart("Gap between setpoints", "ms", ("setpoint_gap",)),
    Chart("Age of what is known of the others", "s", ("link_age",)),
    Chart("Offset of the others' clocks", "ms", ("clock_offset",), from_zero=False),
    Chart("Battery", "%", ("battery",)),
    Chart("Battery voltage", "V", ("battery_voltage",), from_zero=False),
    Chart("Processor load", "% of a core", ("cpu",)),
    Chart("Lateness of the control loop", "ms", ("loop_lateness",)),
)


def chart_figures(run: Run, signals: Sequence[Signal]) -> list[tuple[str, Figure]]:
    """(title, figure) in the order of the report; charts for which nothing was recorded are left out."""
    drawn = [(chart, [one for one in signals if one.quantity in chart.quantities]) for chart in CHARTS]
    return [(chart.title, _figure(run, chart, chosen)) for chart, chosen in drawn if chosen]


def not_recorded(signals: Sequence[Signal]) -> list[str]:
    """Titles of the charts for which nothing was recorded."""
    known = {signal.quantity for signal in signals}
    return [chart.title for chart in CHARTS if not known & set(chart.quantities)]


def _figure(run: Run, chart: Chart, signals: list[Signal]) -> Figure:
    traces = _traces(run, chart, signals)
    layout = plain_layout(f"time since the {origin_name(run)} began, s", chart.unit)
    top = 14 + 20 * _legend_rows(traces)
    layout["height"] = 225 + top
    layout["margin"] = {"l": 56, "r": 14, "t": top, "b": 42}
    layout["legend"] = {"orientation": "h", "x": 0, "y": 1.02, "xanchor": "left", "yanchor": "bottom", "itemsizing": "constant"}
    layout["showlegend"] = True
    layout["xaxis"]["range"] = list(span_s(run))
    if chart.from_zero:
        layout["yaxis"]["rangemode"] = "tozero"
    if chart.shown_max is not None:
        low = min(float(np.nanmin(signal.values, initial=0.0)) for signal in signals)
        layout["yaxis"]["range"] = [min(-0.3, 1.1 * low), max(chart.shown_max, 1.5 * low)]
    layout["shapes"], layout["annotations"] = _reference_lines(run, _threshold(run, chart))
    return {"data": traces, "layout": layout}


def _traces(run: Run, chart: Chart, signals: list[Signal]) -> list[Figure]:
    colours = vehicle_colours(run)
    drawn: dict[str, int] = {}
    traces = []
    for signal in signals:
        number = drawn[signal.vehicle] = drawn.get(signal.vehicle, -1) + 1
        t_s, values = thinned(signal.t_s - origin_s(run), signal.values, _POINTS_MAX)
        colour = colours.get(signal.vehicle, "#7b8794")
        trace: Figure = {
            "type": "scatter",
            "mode": "markers" if chart.markers else "lines",
            "name": signal.label,
            "x": packed(t_s),
            "y": packed(values),
            "hovertemplate": "%{y:.3~f}",
            "line": {"color": colour, "width": 1.6, "dash": _DASHES[number % len(_DASHES)]},
            "marker": {"color": colour, "size": 3.5, "opacity": 0.65},
        }
        traces.append(trace)
    return traces


def _threshold(run: Run, chart: Chart) -> tuple[str, float] | None:
    """The limit that the chart is read against."""
    profiles = [vehicle.profile for vehicle in run.vehicles if vehicle.profile is not None]
    if chart.quantities == ("distance_to_evader",) and run.mission is not None:
        return "capture radius", run.mission.capture.radius_m
    if chart.quantities == ("separation",) and profiles:
        return "required", max(profile.safety.separation_min_m for profile in profiles)
    if chart.quantities == ("clearance",):
        return "contact", 0.0
    return None


def _legend_rows(traces: list[Figure]) -> int:
    """Rows that the legend takes; plotly gives every entry the width of the longest."""
    widest = max((55 + 7 * len(trace["name"]) for trace in traces), default=1)
    return -(-len(traces) // max(1, _LEGEND_PX // widest))


def _reference_lines(run: Run, threshold: tuple[str, float] | None) -> tuple[list[Figure], list[Figure]]:
    shapes: list[Figure] = []
    notes: list[Figure] = []
    when_s = captured_s(run)
    if when_s is not None:
        at_s = when_s - origin_s(run)
        line = {"color": EVADER_COLOUR, "width": 1.2, "dash": "dot"}
        shapes.append({"type": "line", "x0": at_s, "x1": at_s, "yref": "paper", "y0": 0, "y1": 1, "line": line})
    if threshold is not None:
        name, value = threshold
        line = {"color": _RED, "width": 1.2, "dash": "dash"}
        shapes.append({"type": "line", "xref": "paper", "x0": 0, "x1": 1, "y0": value, "y1": value, "line": line})
        note = {"xref": "paper", "x": 1.0, "y": value, "text": name, "showarrow": False, "xanchor": "right", "yanchor": "bottom"}
        notes.append(note | {"font": {"size": 11, "color": _RED}})
    return shapes, notes


def plain_layout(x_title: str, y_title: str) -> Figure:
    """Without colours of paper, ink and grid: the page adds them, light or dark."""
    axis = {"ticks": "outside"}
    return {
        "font": dict(_FONT),
        "hovermode": "x unified",
        "xaxis": axis | {"title": {"text": x_title, "standoff": 8, "font": {"size": 12}}},
        "yaxis": axis | {"title": {"text": y_title, "standoff": 8, "font": {"size": 12}}},
    }


def span_s(run: Run) -> tuple[float, float]:
    """From take-off to the end of the last recording, relative to the origin of the page; from the first sample without one."""
    zero_s = origin_s(run)
    starts = [window.start_s for v in run.vehicles if (window := v.phases.window(("takeoff", "ready", "pursue"))) is not None]
    if not starts:
        starts = [float(series.t_s[0]) for v in run.vehicles for series in v.recording.series.values() if len(series)]
    ends = [vehicle.phases.end_s for vehicle in run.vehicles]
    start_s = min(starts, default=zero_s) - zero_s
    return start_s, max(max(ends, default=zero_s) - zero_s, start_s + 1.0)


def rounded(values: Array | list[float]) -> list[float | None]:
    """Millimetres and milliseconds are enough to look at; what is not a number is null."""
    return [round(value, 3) if np.isfinite(value) else None for value in np.asarray(values, dtype=np.float64).tolist()]

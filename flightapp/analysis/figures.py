"""The report's figures as plotly.js specifications (plain dicts): the map, and charts over the time of the pursuit."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from html import escape
from typing import Any

import numpy as np

from flightapp.analysis import timing
from flightapp.analysis.map_data import EVADER_COLOUR, OTHER_LABEL, MapData, map_data, origin_name, origin_s, vehicle_colours
from flightapp.analysis.outcome import captured_s, pursuers_of
from flightapp.analysis.run import Run, VehicleRun
from flightapp.core.types import Array
from flightapp.recording.phases import AIRBORNE
from flightapp.sim.world import World

Figure = dict[str, Any]
_FONT = {"family": "system-ui, -apple-system, 'Segoe UI', Roboto, Arial, sans-serif", "size": 13, "color": "#1f2933"}
_GRID = "#e4e7eb"
_RED = "#b42318"
_PAPER = "rgba(255,255,255,0.85)"
_LEGEND_PX = 470
"""Width of a chart that its legend may use."""
_POINTS_MAX = 3000
_CLEARANCE_SHOWN_M = 6.0


def map_figure(run: Run) -> Figure:
    """North up, equal axes."""
    data = map_data(run)
    traces = [*_ground(data), *_flown(data), *_marks(data)]
    layout = plain_layout("east, m", "north, m")
    layout["height"] = 760
    layout["margin"] = {"l": 60, "r": 20, "t": 20, "b": 55}
    layout["legend"] = {"orientation": "v", "x": 1.01, "y": 1.0, "xanchor": "left", "yanchor": "top"}
    layout["hovermode"] = "closest"
    layout["annotations"] = _mark_labels(data)
    layout["xaxis"] |= {"range": [data.low_m[1], data.high_m[1]], "constrain": "domain"}
    layout["yaxis"] |= {"range": [data.low_m[0], data.high_m[0]], "scaleanchor": "x", "scaleratio": 1, "constrain": "domain"}
    return {"data": traces, "layout": layout}


def chart_figures(run: Run) -> list[tuple[str, Figure]]:
    """(title, figure) in the order of the report; charts for which nothing was recorded are left out."""
    charts = [
        ("Distance to the evader", _chart(run, "m", _target_distances(run), _capture_radius(run))),
        ("Speed over ground", _chart(run, "m/s", _speeds(run), None)),
        ("Height above the datum", _chart(run, "m", _heights(run), None)),
        ("Clearance to obstacles", _chart(run, "m", _clearances(run), ("contact", 0.0), shown_max=_CLEARANCE_SHOWN_M)),
        ("Planner step", _chart(run, "ms", _decision_latencies(run), None, markers=True)),
        ("Camera to action", _chart(run, "ms", _camera_latencies(run), None, markers=True)),
        ("Age of what is known of the others", _chart(run, "s", _link_ages(run), None)),
        ("Processor load", _chart(run, "% of a core", _processor_loads(run), None)),
    ]
    return [(title, figure) for title, figure in charts if figure["data"]]


def _ground(data: MapData) -> list[Figure]:
    traces = []
    if data.fence is not None:
        traces.append(_outline([data.fence], "fence", "#52606d", dash="dot"))
    if data.boundary is not None:
        traces.append(_outline([data.boundary], "protected boundary", _RED, width=3))
    if data.obstacles:
        traces.append(_outline(data.obstacles, "surveyed obstacle", "#616e7c", fill="rgba(97,110,124,0.22)"))
    if data.perceived:
        traces.append(_outline(data.perceived, "obstacle as perceived", "#d97706", fill="rgba(245,158,11,0.20)"))
    return traces


def _outline(
    lines: Iterable[Array], name: str, colour: str, *, width: float = 1.5, dash: str = "solid", fill: str | None = None
) -> Figure:
    east, north = _joined(lines)
    trace: Figure = {
        "type": "scatter",
        "mode": "lines",
        "name": name,
        "x": east,
        "y": north,
        "line": {"color": colour, "width": width, "dash": dash},
        "hoverinfo": "name",
    }
    return trace if fill is None else trace | {"fill": "toself", "fillcolor": fill}


def _joined(lines: Iterable[Array]) -> tuple[list[float | None], list[float | None]]:
    """East and north of several lines in one trace, null between them."""
    east: list[float | None] = []
    north: list[float | None] = []
    for line in lines:
        if east:
            east.append(None)
            north.append(None)
        east += rounded(line[:, 1])
        north += rounded(line[:, 0])
    return east, north


def _flown(data: MapData) -> list[Figure]:
    traces = []
    legend: set[str] = set()
    for stretch in sorted(data.stretches, key=lambda one: one.label != OTHER_LABEL):
        east, north = _joined([stretch.points_m])
        traces.append(
            {
                "type": "scatter",
                "mode": "lines",
                "name": stretch.label,
                "legendgroup": stretch.label,
                "showlegend": stretch.label not in legend,
                "x": east,
                "y": north,
                "text": [f"{stretch.vehicle}, {t_s:.1f} s" for t_s in stretch.t_s.tolist()],
                "hovertemplate": "%{text}<br>north %{y:.1f} m, east %{x:.1f} m",
                "line": {"color": stretch.colour, "width": 1.2 if stretch.label == OTHER_LABEL else 3},
            }
        )
        legend.add(stretch.label)
    return traces


def _marks(data: MapData) -> list[Figure]:
    return [
        {
            "type": "scatter",
            "mode": "markers",
            "x": rounded([mark.point_m[1]]),
            "y": rounded([mark.point_m[0]]),
            "marker": {
                "symbol": "star" if mark.kind == "capture" else "circle",
                "size": 17 if mark.kind == "capture" else 10,
                "color": mark.colour,
                "line": {"color": "#ffffff", "width": 1.5},
            },
            "hoverinfo": "skip",
            "showlegend": False,
        }
        for mark in data.markers
    ]


def _mark_labels(data: MapData) -> list[Figure]:
    return [
        {
            "x": mark.point_m[1],
            "y": mark.point_m[0],
            "text": f"<b>{escape(mark.text)}</b>",
            "font": {"color": mark.colour},
            "bgcolor": _PAPER,
            "showarrow": mark.kind == "capture",
            "arrowcolor": mark.colour,
            "arrowwidth": 1,
            "arrowhead": 0,
            "standoff": 8,
            "ax": 95,
            "ay": -55,
            "yshift": 0 if mark.kind == "capture" else 18 if mark.label_above else -18,
        }
        for mark in data.markers
    ]


def _chart(
    run: Run,
    unit: str,
    traces: list[Figure],
    threshold: tuple[str, float] | None,
    *,
    markers: bool = False,
    shown_max: float | None = None,
) -> Figure:
    layout = plain_layout(f"time since the {origin_name(run)} began, s", unit)
    top = 14 + 20 * _legend_rows(traces)
    layout["height"] = 225 + top
    layout["margin"] = {"l": 60, "r": 20, "t": top, "b": 45}
    layout["legend"] = {
        "orientation": "h",
        "x": 0.0,
        "y": 1.02,
        "xanchor": "left",
        "yanchor": "bottom",
        "itemsizing": "constant",
    }
    layout["showlegend"] = True
    layout["xaxis"]["range"] = list(_span_s(run))
    layout["yaxis"]["rangemode"] = "tozero"
    if shown_max is not None and traces:
        low = min((value for trace in traces for value in trace["y"] if value is not None), default=0.0)
        layout["yaxis"]["range"] = [min(-0.3, 1.1 * low), max(shown_max, 1.5 * low)]
    if markers:
        traces = [trace | {"mode": "markers", "marker": {"size": 3.5} | trace["marker"]} for trace in traces]
    layout["shapes"], layout["annotations"] = _reference_lines(run, threshold)
    return {"data": traces, "layout": layout}


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
        notes.append(note | {"font": {"size": 11, "color": _RED}, "bgcolor": _PAPER})
    return shapes, notes


def plain_layout(x_title: str, y_title: str) -> Figure:
    axis = {"gridcolor": _GRID, "zerolinecolor": "#cbd2d9", "linecolor": "#9aa5b1", "ticks": "outside", "tickcolor": "#9aa5b1"}
    return {
        "font": _FONT,
        "paper_bgcolor": "#ffffff",
        "plot_bgcolor": "#ffffff",
        "hovermode": "x unified",
        "xaxis": axis | {"title": {"text": x_title, "standoff": 8, "font": {"size": 12}}},
        "yaxis": axis | {"title": {"text": y_title, "standoff": 8, "font": {"size": 12}}},
    }


def _span_s(run: Run) -> tuple[float, float]:
    """From take-off to the end of the last recording, relative to the pursuit."""
    zero_s = origin_s(run)
    starts = [window.start_s for v in run.vehicles if (window := v.phases.window(("takeoff", "ready", "pursue"))) is not None]
    ends = [vehicle.phases.end_s for vehicle in run.vehicles]
    return min(starts, default=zero_s) - zero_s, max(ends, default=zero_s + 1.0) - zero_s


def _trace(
    run: Run, vehicle: str, name: str, t_s: Array, values: Array, *, dash: str = "solid", symbol: str = "circle"
) -> Figure:
    colour = vehicle_colours(run).get(vehicle, "#4a5568")
    step = max(1, -(-len(t_s) // _POINTS_MAX))
    return {
        "type": "scatter",
        "mode": "lines",
        "name": name,
        "x": rounded((t_s - origin_s(run))[::step]),
        "y": rounded(values[::step]),
        "line": {"color": colour, "width": 1.8, "dash": dash},
        "marker": {"color": colour, "symbol": symbol, "opacity": 0.65},
    }


def rounded(values: Array | list[float]) -> list[float | None]:
    """Millimetres and milliseconds are enough to look at; what is not a number is null."""
    return [round(value, 3) if np.isfinite(value) else None for value in np.asarray(values, dtype=np.float64).tolist()]


def _target_distances(run: Run) -> list[Figure]:
    evader = run.evader_track()
    traces = []
    for vehicle in pursuers_of(run):
        if evader is None or vehicle.track is None or vehicle.role == "evader":
            continue
        inside = (vehicle.track.t_s >= evader.t_s[0]) & (vehicle.track.t_s <= evader.t_s[-1])
        times = vehicle.track.t_s[inside]
        gap = vehicle.track.position_ned_m[inside] - evader.at(times).position_ned_m
        traces.append(_trace(run, vehicle.name, vehicle.name, times, np.linalg.norm(gap, axis=1)))
    return traces


def _capture_radius(run: Run) -> tuple[str, float] | None:
    return None if run.mission is None else ("capture radius", run.mission.capture.radius_m)


def _speeds(run: Run) -> list[Figure]:
    return [
        _trace(run, v.name, v.name, v.track.t_s, np.linalg.norm(v.track.velocity_ned_m_s[:, :2], axis=1))
        for v in run.vehicles
        if v.track is not None
    ]


def _heights(run: Run) -> list[Figure]:
    return [_trace(run, v.name, v.name, v.track.t_s, -v.track.position_ned_m[:, 2]) for v in run.vehicles if v.track is not None]


def _clearances(run: Run) -> list[Figure]:
    """True clearance of the body where world and profile are known, and the clearance to the discs known on board."""
    traces = []
    for vehicle in pursuers_of(run):
        true = _true_clearance(run, vehicle)
        if true is not None:
            traces.append(true)
        setpoints = vehicle.recording.topic("/setpoint")
        known = setpoints.column("clearance_m")
        known[known > 10 * _CLEARANCE_SHOWN_M] = np.nan
        if np.isfinite(known).any():
            traces.append(_trace(run, vehicle.name, f"{vehicle.name}, as known on board", setpoints.t_s, known, dash="dot"))
    return traces


def _true_clearance(run: Run, vehicle: VehicleRun) -> Figure | None:
    mission, track, profile = run.mission, vehicle.track, vehicle.profile
    if mission is None or track is None or profile is None or not (mission.obstacles.cylinders or mission.obstacles.boxes):
        return None
    world = World(mission.obstacles)
    distances = np.array([world.signed_distance_m(*point) for point in track.position_ned_m.tolist()])
    return _trace(run, vehicle.name, f"{vehicle.name}, surveyed", track.t_s, distances - profile.limits.body_radius_m)


def _decision_latencies(run: Run) -> list[Figure]:
    decisions = {vehicle.name: vehicle.recording.topic("/decision") for vehicle in run.vehicles}
    return [_trace(run, name, name, s.t_s, s.column("latency_s") * 1e3) for name, s in decisions.items() if len(s)]


def _camera_latencies(run: Run) -> list[Figure]:
    traces = []
    for vehicle in run.vehicles:
        obstacles, setpoints = vehicle.recording.topic("/obstacles"), vehicle.recording.topic("/setpoint")
        if len(obstacles):
            latency = timing.perception_latency_ms(obstacles)
            traces.append(_trace(run, vehicle.name, f"{vehicle.name}, perception", obstacles.t_s, latency, symbol="circle"))
        new = np.array([message.get("new_frame") is True for message in setpoints.messages], dtype=bool)
        if new.any():
            latency = (setpoints.column("t_s") - setpoints.column("frame_t_s"))[new] * 1e3
            name = f"{vehicle.name}, frame to setpoint"
            traces.append(_trace(run, vehicle.name, name, setpoints.t_s[new], latency, symbol="cross"))
    return traces


def _processor_loads(run: Run) -> list[Figure]:
    healths = {vehicle.name: vehicle.recording.topic("/health") for vehicle in run.vehicles}
    return [_trace(run, name, name, s.t_s, s.column("cpu_fraction") * 100.0) for name, s in healths.items() if len(s)]


def _link_ages(run: Run) -> list[Figure]:
    """One line for each pair of vehicles, until the first of them has landed and falls silent."""
    flown = [window for vehicle in run.vehicles if (window := vehicle.phases.window(AIRBORNE)) is not None]
    end_s = min((window.end_s for window in flown), default=math.inf)
    dashes = ("solid", "dot", "dash", "dashdot")
    traces = []
    for vehicle in run.vehicles:
        series = vehicle.recording.topic("/team")
        known = [message for t_s, message in zip(series.t_s.tolist(), series.messages, strict=True) if t_s <= end_s]
        for number, (other, (times, ages)) in enumerate(sorted(_ages(series.t_s[: len(known)], known).items())):
            name = f"{vehicle.name} of {other}"
            traces.append(_trace(run, vehicle.name, name, np.array(times), np.array(ages), dash=dashes[number % len(dashes)]))
    return traces


def _ages(t_s: Array, messages: list[dict[str, Any]]) -> Mapping[str, tuple[list[float], list[float]]]:
    ages: dict[str, tuple[list[float], list[float]]] = {}
    for time, message in zip(t_s.tolist(), messages, strict=True):
        for member in message.get("members", []):
            times, values = ages.setdefault(str(member["name"]), ([], []))
            times.append(time)
            values.append(float(member["age_s"]))
    return ages

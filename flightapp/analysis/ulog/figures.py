"""Charts of one PX4 log, as plotly figures; those for which nothing was logged are left out."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flightapp.analysis.figures import Figure, plain_layout, rounded
from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.ulog.log import FlightLog, Topic
from flightapp.analysis.ulog.response import response_of
from flightapp.core.types import Array

Shift = Callable[[Array], Array]
"""Times of the log to times of the page."""
_COLOURS = ("#1f6feb", "#d97706", "#1a7f43", "#8250df")
_SHADES = {Severity.WARNING: "rgba(199,119,0,0.10)", Severity.FAILURE: "rgba(180,35,24,0.12)"}
_POINTS_MAX = 3000


def log_figures(log: FlightLog, findings: list[Finding], x_title: str, shift: Shift) -> list[tuple[str, Figure]]:
    """(title, figure). `shift` puts the times of the log on the page's time line; findings are on that line already."""
    charts = [
        ("Velocity north and its setpoint", "m/s", _velocity(log, 0, shift), ("tracking", "offboard")),
        ("Velocity east and its setpoint", "m/s", _velocity(log, 1, shift), ("tracking", "offboard")),
        ("Height above the place of arming", "m", _height(log, shift), ("estimator",)),
        ("Battery", "V", _lines(log, shift, "battery_status", {"voltage_v": "voltage"}), ("battery",)),
        ("5 V rail of the autopilot", "V", _lines(log, shift, "system_power", {"voltage5v_v": "5 V rail"}), ("power",)),
        ("GPS: satellites and interference", "", _gps(log, shift), ("GPS",)),
        ("Innovation test ratios", "1 = rejected", _ratios(log, shift), ("estimator",)),
        ("Vibration", "m/s²", _vibration(log, shift), ("vibration",)),
    ]
    return [(title, _chart(traces, x_title, unit, findings, about)) for title, unit, traces, about in charts if traces]


def _chart(traces: list[Figure], x_title: str, unit: str, findings: list[Finding], about: tuple[str, ...]) -> Figure:
    layout = plain_layout(x_title, unit)
    layout["height"] = 260
    layout["margin"] = {"l": 60, "r": 20, "t": 34, "b": 45}
    layout["legend"] = {"orientation": "h", "x": 0.0, "y": 1.02, "xanchor": "left", "yanchor": "bottom"}
    layout["showlegend"] = True
    layout["shapes"] = [_shade(finding) for finding in findings if finding.analyser in about and finding.severity in _SHADES]
    layout["shapes"] = [shape for shape in layout["shapes"] if shape]
    return {"data": traces, "layout": layout}


def _shade(finding: Finding) -> Figure:
    if finding.from_s is None or finding.to_s is None:
        return {}
    place = {"type": "rect", "x0": finding.from_s, "x1": finding.to_s, "yref": "paper", "y0": 0, "y1": 1, "layer": "below"}
    return place | {"fillcolor": _SHADES[finding.severity], "line": {"width": 0}}


def _line(name: str, t_s: Array, values: Array, number: int, *, dash: str = "solid") -> Figure:
    step = max(1, -(-len(t_s) // _POINTS_MAX))
    return {
        "type": "scatter",
        "mode": "lines",
        "name": name,
        "x": rounded(t_s[::step]),
        "y": rounded(values[::step]),
        "line": {"color": _COLOURS[number % len(_COLOURS)], "width": 1.8, "dash": dash},
    }


def _lines(log: FlightLog, shift: Shift, topic: str, columns: dict[str, str]) -> list[Figure]:
    return _of(log.topic(topic), shift, columns)


def _of(topic: Topic | None, shift: Shift, columns: dict[str, str]) -> list[Figure]:
    if topic is None:
        return []
    known = [(name, values) for column, name in columns.items() if (values := topic.column(column)) is not None]
    known = [(name, values) for name, values in known if np.isfinite(values).any()]
    return [_line(name, shift(topic.t_s), values, number) for number, (name, values) in enumerate(known)]


def _velocity(log: FlightLog, axis: int, shift: Shift) -> list[Figure]:
    achieved = _lines(log, shift, "vehicle_local_position", {("vx", "vy")[axis]: "achieved"})
    response = response_of(log)
    if response is None:
        return achieved
    return [*achieved, _line("setpoint", shift(response.t_s), response.wanted_m_s[:, axis], 1, dash="dot")]


def _height(log: FlightLog, shift: Shift) -> list[Figure]:
    local = log.topic("vehicle_local_position")
    down = None if local is None else local.column("z")
    if local is None or down is None:
        return []
    armed = log.armed()
    ground = down[int(np.searchsorted(local.t_s, armed[0].from_s))] if armed and armed[0].from_s < local.t_s[-1] else down[0]
    return [_line("height", shift(local.t_s), ground - down, 0)]


def _gps(log: FlightLog, shift: Shift) -> list[Figure]:
    topic = log.topic("vehicle_gps_position") or log.topic("sensor_gps")
    return _of(topic, shift, {"satellites_used": "satellites", "jamming_indicator": "jamming indicator, of 255"})


def _ratios(log: FlightLog, shift: Shift) -> list[Figure]:
    names = {
        "pos_test_ratio": "position",
        "vel_test_ratio": "velocity",
        "hgt_test_ratio": "height",
        "mag_test_ratio": "magnetometer",
    }
    return _lines(log, shift, "estimator_status", names)


def _vibration(log: FlightLog, shift: Shift) -> list[Figure]:
    known = enumerate(log.topics.get("vehicle_imu_status", ()))
    columns = [(number, topic, topic.column("accel_vibration_metric")) for number, topic in known]
    return [_line(f"accelerometer {n}", shift(topic.t_s), v, n) for n, topic, v in columns if v is not None]

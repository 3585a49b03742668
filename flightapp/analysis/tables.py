"""The report's tables as HTML. Every recorded text is escaped."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from html import escape
from typing import Any

from flightapp.analysis.map_data import origin_s
from flightapp.analysis.run import Run
from flightapp.analysis.summary import Summary

UNKNOWN = "–"


def figures_table(summary: Summary) -> str:
    """The figures of the whole run."""
    boundary = summary["boundary_distance_m"], summary["boundary_distance_at_capture_m"]
    required, wanted = summary["separation_required_m"], summary["clearance_wanted_m"]
    rows = [
        ("Outcome", escape(summary["outcome"] or UNKNOWN)),
        ("Time to capture", number(summary["capture_time_s"], 1, "s")),
        ("Path length, mean of the pursuers", number(summary["path_length_m"], 1, "m")),
        (
            "Smallest clearance to an obstacle",
            number(summary["min_obstacle_clearance_m"], 2, "m") + ("" if wanted is None else f" (margin {wanted:.2f} m)"),
        ),
        (
            "Smallest separation of the pursuers",
            number(summary["min_separation_m"], 2, "m") + ("" if required is None else f" (required {required:.2f} m)"),
        ),
        ("Smallest distance to the evader", number(summary["min_target_distance_m"], 2, "m")),
        ("Evader to boundary, smallest / at capture", pair(*boundary, 1, "m")),
        ("Mean jerk", number(summary["mean_jerk_m_s3"], 2, "m/s³")),
        ("Planner step, coarse, p50 / p99", percentiles(summary["decision_latency_ms"]["coarse"])),
        ("Planner step, fine, p50 / p99", percentiles(summary["decision_latency_ms"]["fine"])),
        ("Perception, p50 / p99", percentiles(summary["perception_latency_ms"])),
        ("Frame to setpoint, p50 / p99", percentiles(summary["frame_to_setpoint_ms"])),
        ("Setpoints, slowest rate", number(summary["setpoint_rate_hz"], 1, "Hz")),
        ("Setpoints, longest gap", number(summary["setpoint_gap_max_ms"], 0, "ms")),
        ("Messages not recorded", number(summary["dropped"], 0, "")),
    ]
    return plain_table([], rows, "figures")


def vehicles_table(summary: Summary) -> str:
    """One column for each vehicle."""
    vehicles = summary["vehicles"]
    lines: list[tuple[str, Callable[[dict[str, Any]], str]]] = [
        ("Role", lambda v: escape(v["role"] or UNKNOWN)),
        ("Outcome", lambda v: escape(v["outcome"] or UNKNOWN)),
        ("Path", lambda v: number(v["path_length_m"], 1, "m")),
        ("Top speed", lambda v: number(v["speed_max_m_s"], 1, "m/s")),
        ("Smallest clearance", lambda v: number(v["min_obstacle_clearance_m"], 2, "m")),
        ("Mean jerk", lambda v: number(v["mean_jerk_m_s3"], 2, "m/s³")),
        ("Perception p50 / p99", lambda v: percentiles(v["perception_latency_ms"])),
        ("Frame to setpoint p50 / p99", lambda v: percentiles(v["frame_to_setpoint_ms"])),
        ("Setpoint rate", lambda v: number(v["setpoint_rate_hz"], 1, "Hz")),
        ("Longest setpoint gap", lambda v: number(v["setpoint_gap_max_ms"], 0, "ms")),
        ("CPU, mean / max", lambda v: load(v["cpu_fraction"], 100.0, "% of a core")),
        ("Memory, mean / max", lambda v: load(v["memory_mb"], 1.0, "MB")),
        ("Modes", lambda v: modes(v["modes"])),
        ("Not recorded", lambda v: number(v["dropped"], 0, "")),
    ]
    rows = [(label, *(show(figures) for figures in vehicles.values())) for label, show in lines]
    return plain_table(["", *(escape(name) for name in vehicles)], rows, "vehicles")


EVENT_LEVELS = ("error", "warning", "phase", "info")


def events_section(run: Run) -> str:
    """Events and phases of all vehicles in the order of their times, to be chosen by level and by text."""
    zero_s = origin_s(run)
    found: list[tuple[float, str, str, str, str]] = []
    for vehicle in run.vehicles:
        events = vehicle.recording.topic("/event")
        for t_s, event in zip(events.t_s.tolist(), events.messages, strict=True):
            level, name, text = (str(event.get(key, "")) for key in ("level", "name", "text"))
            found.append((t_s, vehicle.name, level if level in EVENT_LEVELS else "info", name, text))
        phases = vehicle.recording.topic("/phase")
        for t_s, phase in zip(phases.t_s.tolist(), phases.messages, strict=True):
            outcome = phase.get("outcome")
            texts = [str(phase.get("reason") or ""), f"outcome {outcome}" if outcome else ""]
            found.append((t_s, vehicle.name, "phase", str(phase.get("phase")), "; ".join(text for text in texts if text)))
    if not found:
        return '<section><h2>Events</h2><p class="note">No events were recorded.</p></section>'
    rows = "".join(_event_row(zero_s, *event) for event in sorted(found))
    head = "".join(f"<th>{name}</th>" for name in ("Time, s", "Vehicle", "Level", "Name", "What happened"))
    table = f'<table class="events" id="events"><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>'
    return f'<section><h2>Events</h2>{_filters(found)}<div class="scroll">{table}</div></section>'


def _event_row(zero_s: float, t_s: float, vehicle: str, level: str, name: str, text: str) -> str:
    return (
        f'<tr data-level="{level}"><td>{time_button(t_s - zero_s)}</td><td>{escape(vehicle)}</td>'
        f'<td><span class="badge {level}">{level}</span></td><td>{escape(name)}</td><td>{escape(text)}</td></tr>'
    )


def _filters(found: Sequence[tuple[float, str, str, str, str]]) -> str:
    boxes = "".join(
        f'<label><input type="checkbox" data-level-filter="{level}" checked> {level} '
        f"({sum(event[2] == level for event in found)})</label>"
        for level in EVENT_LEVELS
    )
    search = (
        '<input type="search" id="event-text" placeholder="vehicle, name or text" aria-label="Show only events with this text">'
    )
    return f'<div class="filters">{boxes}{search}</div>'


def time_button(t_s: float) -> str:
    """A time since the page's origin, s; a click on it takes the slider there."""
    return f'<button type="button" class="time" data-t="{t_s:.3f}">{round(t_s, 1) + 0.0:.1f}</button>'


def recordings_table(summary: Summary) -> str:
    """Files and whether they are whole."""
    rows = [(escape(one["file"]), escape(one["error"] or "complete")) for one in summary["recordings"]]
    return plain_table(["File", "State"], rows, "recordings")


def number(value: float | None, digits: int, unit: str) -> str:
    return UNKNOWN if value is None else f"{value:.{digits}f} {unit}".strip()


def pair(first: float | None, second: float | None, digits: int, unit: str) -> str:
    if first is None and second is None:
        return UNKNOWN
    return f"{number(first, digits, '')} / {number(second, digits, '')} {unit}"


def percentiles(spread: dict[str, float | None]) -> str:
    return pair(spread["p50"], spread["p99"], 1, "ms")


def load(spread: dict[str, float | None], scale: float, unit: str) -> str:
    scaled = [None if spread[name] is None else scale * float(spread[name] or 0.0) for name in ("mean", "max")]
    return pair(scaled[0], scaled[1], 0, unit)


def modes(shares: dict[str, float]) -> str:
    ordered = sorted(shares.items(), key=lambda item: -item[1])
    return "<br>".join(f"{escape(mode)} {100 * part:.0f} %" for mode, part in ordered) or UNKNOWN


def plain_table(head: Sequence[str], rows: Sequence[tuple[str, ...]], name: str) -> str:
    """Cells are HTML already."""
    top = f"<thead><tr>{''.join(f'<th>{cell}</th>' for cell in head)}</tr></thead>" if head else ""
    body = "".join(f"<tr>{''.join(f'<td>{cell}</td>' for cell in row)}</tr>" for row in rows)
    return f'<table class="{name}">{top}<tbody>{body}</tbody></table>'

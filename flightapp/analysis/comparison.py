"""Several runs beside each other: the figures of their summaries and how they differ. Every text is escaped."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from flightapp.analysis.tables import UNKNOWN, plain_table

_FIGURES = (
    ("capture_time_s", "Time to capture", "s", 1),
    ("path_length_m", "Path length, mean of the pursuers", "m", 1),
    ("mean_jerk_m_s3", "Mean jerk", "m/s³", 2),
    ("min_obstacle_clearance_m", "Smallest clearance to an obstacle", "m", 2),
    ("min_separation_m", "Smallest separation of the pursuers", "m", 2),
    ("min_target_distance_m", "Smallest distance to the evader", "m", 2),
    ("boundary_distance_m", "Evader to boundary, smallest", "m", 1),
    ("boundary_distance_at_capture_m", "Evader to boundary at capture", "m", 1),
    ("decision_latency_ms.coarse.p99", "Planner step, coarse, p99", "ms", 2),
    ("decision_latency_ms.fine.p99", "Planner step, fine, p99", "ms", 2),
    ("perception_latency_ms.p99", "Perception, p99", "ms", 1),
    ("frame_to_setpoint_ms.p50", "Frame to setpoint, p50", "ms", 1),
    ("frame_to_setpoint_ms.p99", "Frame to setpoint, p99", "ms", 1),
    ("setpoint_rate_hz", "Setpoints, slowest rate", "Hz", 1),
    ("setpoint_gap_max_ms", "Setpoints, longest gap", "ms", 0),
    ("cpu_fraction.max", "Processor, greatest share of a core", "", 2),
    ("memory_mb.max", "Memory, greatest", "MB", 0),
    ("dropped", "Messages not recorded", "", 0),
)


def differences(summary: Mapping[str, Any], others: Mapping[str, Mapping[str, Any]]) -> list[dict[str, Any]]:
    """For summary.json: of each figure the value here, and of each other run its value and difference; null: not known."""
    rows = []
    for path, _, unit, _ in _FIGURES:
        own = _value(summary, path)
        compared = {name: _value(other, path) for name, other in others.items()}
        rows.append(
            {
                "figure": path,
                "unit": unit,
                "value": own,
                "others": {
                    name: {"value": value, "difference": None if own is None or value is None else value - own}
                    for name, value in compared.items()
                },
            }
        )
    return rows


def comparison_section(summary: Mapping[str, Any], others: Mapping[str, Mapping[str, Any]], remarks: Sequence[str]) -> str:
    """The table, and what about the comparison must be known; nothing where nothing is compared."""
    if not others:
        return ""
    rows: list[tuple[str, ...]] = [
        ("Outcome", *(escape(str(one["outcome"] or UNKNOWN)) for one in (summary, *others.values()))),
        ("Verdict", *(escape(str(one["verdict"])) for one in (summary, *others.values()))),
    ]
    for (_, label, unit, digits), row in zip(_FIGURES, differences(summary, others), strict=True):
        told = [_cell(other["value"], other["difference"], digits) for other in row["others"].values()]
        if row["value"] is not None or any(other["value"] is not None for other in row["others"].values()):
            rows.append((f"{label}, {unit}" if unit else label, _number(row["value"], digits), *told))
    table = plain_table(["", "This run", *(escape(name) for name in others)], rows, "comparison")
    notes = "".join(f'<p class="note">{escape(remark)}</p>' for remark in remarks)
    return f'<section id="comparison"><h2>Compared</h2>{notes}<div class="wide">{table}</div></section>'


def _cell(value: float | None, difference: float | None, digits: int) -> str:
    if value is None or difference is None:
        return _number(value, digits)
    told = f"{difference:+.{digits}f}"
    return f"{_number(value, digits)} ({'±0' if float(told) == 0.0 else told})"


def _number(value: float | None, digits: int) -> str:
    return UNKNOWN if value is None else f"{value:.{digits}f}"


def _value(summary: Mapping[str, Any], path: str) -> float | None:
    value: Any = summary
    for name in path.split("."):
        value = value.get(name) if isinstance(value, Mapping) else None
    return float(value) if isinstance(value, (int, float)) else None

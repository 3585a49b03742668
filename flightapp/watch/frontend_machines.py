"""One look at the fleet as one line of JSON, and as plain text."""

from __future__ import annotations

from typing import Any

import orjson

from flightapp.watch.data_model_fleet import Overview
from flightapp.watch.data_model_rows import Row
from flightapp.watch.data_model_thresholds import Thresholds
from flightapp.watch.frontend_cells import HEADINGS, cells_of, leader_text, target_text

DIGITS = 3


def as_json_line(overview: Overview) -> str:
    """Units are in the names; null: not known, or there is none. Events are not repeated: `alarms` say what holds now."""
    target = overview.target
    return orjson.dumps(
        {
            "time_s": _rounded(overview.now_s),
            "mission": overview.mission,
            "fleet": overview.fleet,
            "leader": overview.leadership.leader,
            "term": overview.leadership.term,
            "vehicles": [_vehicle(row) for row in overview.rows],
            "target": None
            if target is None
            else {
                "name": target.name,
                "source": target.source,
                "age_s": _rounded(target.age_s),
                "north_m": _rounded(target.north_m),
                "east_m": _rounded(target.east_m),
                "speed_m_s": _rounded(target.speed_m_s),
                "boundary_distance_m": _rounded(target.boundary_distance_m),
                "boundary_time_s": _rounded(target.boundary_time_s),
            },
            "alarms": [{"level": one.level.name.lower(), "vehicle": one.vehicle, "text": one.text} for one in overview.alarms],
        }
    ).decode()


def as_text(overview: Overview, thresholds: Thresholds) -> str:
    """A table, leader, target and alarms, without colours."""
    lines = [list(HEADINGS)] + [[cell.text for cell in cells_of(row, thresholds)] for row in overview.rows]
    widths = [max(len(line[column]) for line in lines) for column in range(len(HEADINGS))]
    table = ["  ".join(text.ljust(width) for text, width in zip(line, widths, strict=True)).rstrip() for line in lines]
    alarms = [f"{alarm.level.name}: {alarm.text}" for alarm in overview.alarms]
    return "\n".join([*table, leader_text(overview), target_text(overview), *alarms])


def _vehicle(row: Row) -> dict[str, Any]:
    state = row.state
    told: dict[str, Any] = {
        "name": row.name,
        "role": row.role,
        "link": row.link.value,
        "age_s": _rounded(row.age_s),
        "leads": row.leads,
        "clock_ahead_s": None if row.offset is None else _rounded(row.offset.ahead_s),
        "clock_uncertainty_s": None if row.offset is None else _rounded(row.offset.uncertainty_s),
        "guards": {guard: _rounded(acting_s) for guard, acting_s in row.guards},
    }
    if state is None:
        return told
    return told | {
        "phase": state.phase,
        "mode": state.mode,
        "outcome": state.outcome,
        "airborne": state.airborne,
        "position_ned_m": state.position_ned_m,
        "velocity_ned_m_s": state.velocity_ned_m_s,
        "yaw_rad": state.yaw_rad,
        "height_m": _rounded(row.height_m),
        "speed_m_s": _rounded(row.speed_m_s),
        "target_distance_m": state.target_distance_m,
        "clearance_m": state.clearance_m,
        "battery_fraction": state.battery_fraction,
        "hears_others_age_s": state.link_age_s,
        "goal_ned_m": state.goal_ned_m,
        "mission": state.mission,
    }


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, DIGITS)

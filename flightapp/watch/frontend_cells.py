"""A row as short texts for a table. A mark or a word says what a colour says: !, late, LOST."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from flightapp.fleet.shared_state import SharedState
from flightapp.watch.data_model_fleet import Overview
from flightapp.watch.data_model_rows import SHAPING, Link, Row
from flightapp.watch.data_model_target import TELEMETRY
from flightapp.watch.data_model_thresholds import Thresholds

HEADINGS = ("name", "role", "phase", "mode", "h m", "m/s", "tgt m", "gap m", "bat %", "link s", "clock", "guards")
LEADS = "*"
WIDTHS = (8, 10, 10, 5, 5, 6, 6, 6, 10, 8, 24)
"""Of all columns but the names', with a space; fixed, so that nothing jumps. Without guards they fit a terminal of 80."""
MODE_LENGTH = WIDTHS[2] - 1
"""Outcomes are no longer than that."""
UNKNOWN = "-"


class Look(Enum):
    """What a style sheet makes colours of."""

    PLAIN = "plain"
    GOOD = "good"
    WARNING = "warning"
    BAD = "bad"
    FAINT = "faint"


@dataclass(frozen=True, slots=True)
class Cell:
    text: str
    look: Look = Look.PLAIN


def cells_of(row: Row, thresholds: Thresholds) -> tuple[Cell, ...]:
    """In the order of HEADINGS."""
    name = Cell(row.name + (LEADS if row.leads else ""))
    link = _link(row)
    state = row.state
    if state is None:
        return (name, Cell(row.role), link, *(Cell(UNKNOWN, Look.FAINT),) * 8, Cell(""))
    stale = Look.FAINT if row.link in (Link.LOST, Link.OVER) else Look.PLAIN
    close = state.clearance_m is not None and state.airborne and state.clearance_m < thresholds.clearance_min_m
    clearance = Cell(_number(state.clearance_m, 1) + ("!" if close else ""), Look.BAD if close else stale)
    return (
        name,
        Cell(row.role),
        Cell(state.phase, stale),
        Cell(_mode(state), stale),
        Cell(_number(row.height_m, 1), stale),
        Cell(_number(row.speed_m_s, 1), stale),
        Cell(_number(state.target_distance_m, 1), stale),
        clearance,
        _battery(state, thresholds, stale),
        link,
        _clock(row, thresholds),
        _guards(row),
    )


def leader_text(overview: Overview) -> str:
    """Who leads, in which term, backed by whom."""
    leadership = overview.leadership
    if leadership.leader is None:
        return f"nobody leads, term {leadership.term}" if leadership.is_voted else "no election heard"
    backed = f", backed by {', '.join(leadership.followers)}" if leadership.followers else ""
    return f"{leadership.leader}{LEADS} leads, term {leadership.term}{backed}"


def target_text(overview: Overview) -> str:
    """One line about the target."""
    target = overview.target
    if target is None:
        return "target: nothing is known of one"
    source = target.source if target.source == TELEMETRY else f"seen by {target.source}"
    time = "" if target.boundary_time_s is None else f", {target.boundary_time_s:.0f} s as it flies"
    speed = "" if target.speed_m_s is None else f", {target.speed_m_s:.1f} m/s"
    return (
        f"target {target.name}: N {round(target.north_m)} E {round(target.east_m)} m{speed}, "
        f"boundary {target.boundary_distance_m:.1f} m{time} ({source}, {target.age_s:.1f} s ago)"
    )


def _mode(state: SharedState) -> str:
    """Once the pursuit has ended, how; until then what the planner does."""
    if state.outcome is not None:
        return state.outcome
    return UNKNOWN if state.mode == state.phase else state.mode[:MODE_LENGTH]


def _battery(state: SharedState, thresholds: Thresholds, usual: Look) -> Cell:
    left = state.battery_fraction
    if left is None:
        return Cell(UNKNOWN, Look.FAINT)
    if left > thresholds.battery_reserve_fraction:
        return Cell(f"{left:.0%}"[:-1], usual)
    is_critical = left <= thresholds.battery_critical_fraction
    return Cell(f"{left:.0%}"[:-1] + "!", Look.BAD if is_critical else Look.WARNING)


def _guards(row: Row) -> Cell:
    """Those that keep a distance or a volume first."""
    names = sorted((guard for guard, _ in row.guards), key=lambda guard: guard in SHAPING)
    return Cell(",".join(names), Look.FAINT if set(names) <= set(SHAPING) else Look.WARNING)


def _link(row: Row) -> Cell:
    if row.age_s is None:
        return Cell(row.link.value, Look.WARNING)
    if row.link is Link.FRESH:
        return Cell(f"{row.age_s:.2f}", Look.GOOD)
    age = f"{row.age_s:.1f}" if row.age_s < 100.0 else f"{row.age_s:.0f}"
    look = {Link.LATE: Look.WARNING, Link.LOST: Look.BAD}.get(row.link, Look.FAINT)
    return Cell(f"{age} {row.link.value}", look)


def _clock(row: Row, thresholds: Thresholds) -> Cell:
    """How far its clock is ahead of this machine's."""
    if row.offset is None:
        return Cell(UNKNOWN, Look.FAINT)
    is_off = abs(row.offset.ahead_s) > thresholds.clock_ahead_max_s
    text = f"{round(row.offset.ahead_s * 1e3):+d}" if abs(row.offset.ahead_s) < 10.0 else f"{row.offset.ahead_s:+.0f} s"
    return Cell(text + ("!" if is_off else ""), Look.WARNING if is_off else Look.PLAIN)


def _number(value: float | None, digits: int) -> str:
    return UNKNOWN if value is None or not math.isfinite(value) else f"{value:.{digits}f}"

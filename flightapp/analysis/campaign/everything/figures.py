"""The figures of one planner in one scenario, from rows of the ledger."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from flightapp.analysis.campaign.everything.episode_row import BROKEN, REFUSED, Row, quantile_us
from flightapp.analysis.campaign.everything.grid import Grid
from flightapp.analysis.campaign.statistics import wilson_interval

Figures = dict[str, Any]


def all_figures(grid: Grid, rows: Sequence[Row]) -> list[Figures]:
    """One entry for each scenario and planner that has rows, in the order of the grid; the last row of an episode counts."""
    seeds = set(grid.seeds)
    found: dict[tuple[str, str], dict[int, Row]] = {}
    for row in rows:
        if row["seed"] in seeds:
            found.setdefault((row["scenario"], row["planner"]), {})[row["seed"]] = row
    return [
        {"family": family, **_figures(name, planner, list(found[name, planner].values()))}
        for family, names in grid.families
        for name in names
        for planner in grid.planners
        if (name, planner) in found
    ]


def _figures(scenario: str, planner: str, rows: Sequence[Row]) -> Figures:
    captured = [row for row in rows if row["outcome"] == "captured"]
    outcomes = Counter(row["outcome"] for row in rows)
    flew = [row for row in rows if row["outcome"] not in (REFUSED, BROKEN)]
    collided = Counter(row["collided_with"] for row in flew if row["outcome"] == "collided")
    low, high = wilson_interval(len(captured), len(rows))
    whys = Counter(row["why"] for row in rows if row.get("why"))
    bins: Counter[int] = Counter()
    for row in flew:
        bins.update({int(number): count for number, count in row["decision_histogram"].items()})
    return {
        "scenario": scenario,
        "planner": planner,
        "runs": len(rows),
        "success_rate": len(captured) / len(rows),
        "success_ci95_low": low,
        "success_ci95_high": high,
        "capture_time_s": _of(captured, "capture_time_s", 50),
        "capture_time_p90_s": _of(captured, "capture_time_s", 90),
        "encircled_at_capture_rate": _mean(captured, "encircled_at_capture"),
        "encircled_first_s": _of(flew, "encircled_first_s", 50),
        "encircled_share": _mean(flew, "encircled_share"),
        "hit_obstacle_rate": collided["obstacle"] / len(rows),
        "hit_teammate_rate": collided["teammate"] / len(rows),
        "escape_rate": outcomes["escaped"] / len(rows),
        "timeout_rate": outcomes["timed_out"] / len(rows),
        "refused_rate": outcomes[REFUSED] / len(rows),
        "broken_rate": outcomes[BROKEN] / len(rows),
        "min_clearance_m": _of(flew, "min_clearance_m", 0),
        "median_clearance_m": _of(flew, "min_clearance_m", 50),
        "min_separation_m": _of(flew, "min_separation_m", 0),
        "median_separation_m": _of(flew, "min_separation_m", 50),
        "travel_m": _of(captured, "travel_m", 50),
        "turning_rad": _of(captured, "turning_rad", 50),
        "decision_p50_us": quantile_us(bins, 0.5),
        "decision_p99_us": quantile_us(bins, 0.99),
        "cpu_s": _mean(flew, "cpu_s"),
        "why": whys.most_common(1)[0][0] if whys else "",
    }


def _values(rows: Sequence[Row], name: str) -> list[float]:
    return [float(row[name]) for row in rows if row.get(name) is not None]


def _of(rows: Sequence[Row], name: str, percentile: float) -> float | None:
    values = _values(rows, name)
    return float(np.percentile(values, percentile)) if values else None


def _mean(rows: Sequence[Row], name: str) -> float | None:
    values = _values(rows, name)
    return float(np.mean(values)) if values else None

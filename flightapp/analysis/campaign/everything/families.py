"""Each planner over all scenarios of a family together: what few seeds a scenario can tell."""

from __future__ import annotations

from collections.abc import Sequence

from flightapp.analysis.campaign.everything.figures import Figures
from flightapp.analysis.campaign.everything.grid import Grid
from flightapp.analysis.campaign.statistics import wilson_interval
from flightapp.analysis.campaign.table import DASH, aligned

HEADINGS = (
    "planner",
    "runs",
    "captured %",
    "95 % interval",
    "encircled % of captures",
    "hit obstacle %",
    "hit mate %",
    "escaped %",
    "timed out %",
    "clearance m",
    "separation m",
)


def family_tables(grid: Grid, figures: Sequence[Figures]) -> list[str]:
    """Heading and table of every family that has runs."""
    parts = []
    for family, names in grid.families:
        rows = []
        for planner in grid.planners:
            some = [entry for entry in figures if entry["planner"] == planner and entry["scenario"] in names]
            if some:
                rows.append([planner, *_pooled(some)])
        if rows:
            parts += [f"### {family}", aligned(HEADINGS, rows)]
    return parts


def _pooled(entries: Sequence[Figures]) -> list[str]:
    """Every run counts the same, whatever its scenario."""
    runs = sum(entry["runs"] for entry in entries)
    captures = [round(entry["runs"] * entry["success_rate"]) for entry in entries]
    captured = sum(captures)
    low, high = wilson_interval(captured, runs)
    encircled = sum((entry["encircled_at_capture_rate"] or 0.0) * count for entry, count in zip(entries, captures, strict=True))
    return [
        str(runs),
        f"{100.0 * captured / runs:.0f}",
        f"{100.0 * low:.0f} to {100.0 * high:.0f}",
        f"{100.0 * encircled / captured:.0f}" if captured else DASH,
        *(
            f"{100.0 * sum(entry['runs'] * entry[field] for entry in entries) / runs:.1f}"
            for field in ("hit_obstacle_rate", "hit_teammate_rate", "escape_rate", "timeout_rate")
        ),
        *(_least(entries, field) for field in ("min_clearance_m", "min_separation_m")),
    ]


def _least(entries: Sequence[Figures], field: str) -> str:
    values = [entry[field] for entry in entries if entry[field] is not None]
    return f"{round(min(values), 2) + 0.0:.2f}" if values else DASH  # no -0.00

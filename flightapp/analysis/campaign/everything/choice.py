"""Which planner to choose in which scenario, from the figures: the surest, the quickest that is no less sure, the best ring."""

from __future__ import annotations

from collections.abc import Sequence

from flightapp.analysis.campaign.everything.figures import Figures
from flightapp.analysis.campaign.everything.grid import Grid
from flightapp.analysis.campaign.table import DASH

HEADINGS = ("scenario", "surest", "captured %", "as sure and quickest", "time s", "as sure and most encircled", "encircled %")
RUNS_MIN = 10
"""With fewer runs of a planner nothing is said."""


def choices(grid: Grid, figures: Sequence[Figures]) -> list[list[str]]:
    """A row for each scenario; "as sure": its 95 % interval of success overlaps that of the surest."""
    rows = []
    for _, names in grid.families:
        for name in names:
            some = [entry for entry in figures if entry["scenario"] == name and entry["runs"] >= RUNS_MIN]
            if some:
                rows.append([name, *_choice(some)])
    return rows


def _choice(entries: Sequence[Figures]) -> list[str]:
    surest = max(entries, key=lambda entry: entry["success_rate"])
    if surest["success_rate"] == 0.0:
        return ["none", "0", DASH, DASH, DASH, DASH]
    sure = [
        entry
        for entry in entries
        if entry["success_ci95_high"] >= surest["success_ci95_low"] and entry["capture_time_s"] is not None
    ]
    quickest = min(sure, key=lambda entry: entry["capture_time_s"])
    ring = max(sure, key=lambda entry: entry["encircled_at_capture_rate"])
    best = [entry["planner"] for entry in entries if entry["success_rate"] == surest["success_rate"]]
    return [
        ", ".join(best) if len(best) < len(entries) else "all",
        f"{100.0 * surest['success_rate']:.0f}",
        quickest["planner"],
        f"{quickest['capture_time_s']:.1f}",
        ring["planner"] if ring["encircled_at_capture_rate"] > 0.0 else DASH,
        f"{100.0 * ring['encircled_at_capture_rate']:.0f}",
    ]

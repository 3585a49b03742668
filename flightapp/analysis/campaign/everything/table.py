"""The table over everything for a person (Markdown) and for a spreadsheet (CSV)."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence

from flightapp.analysis.campaign.everything.choice import HEADINGS, RUNS_MIN, choices
from flightapp.analysis.campaign.everything.families import family_tables
from flightapp.analysis.campaign.everything.figures import Figures
from flightapp.analysis.campaign.everything.grid import Grid
from flightapp.analysis.campaign.table import DASH, aligned

COLUMNS = (
    ("success_rate", "success %", 100.0, 0),
    ("capture_time_s", "time s", 1.0, 1),
    ("encircled_at_capture_rate", "encircled at capture %", 100.0, 0),
    ("encircled_share", "share of time encircled %", 100.0, 0),
    ("hit_obstacle_rate", "hit obstacle %", 100.0, 0),
    ("hit_teammate_rate", "hit mate %", 100.0, 0),
    ("escape_rate", "escaped %", 100.0, 0),
    ("timeout_rate", "timed out %", 100.0, 0),
    ("min_clearance_m", "clearance m", 1.0, 2),
    ("min_separation_m", "separation m", 1.0, 2),
    ("travel_m", "travel m", 1.0, 0),
    ("turning_rad", "turning rad", 1.0, 0),
    ("decision_p50_us", "p50 us", 1.0, 0),
    ("decision_p99_us", "p99 us", 1.0, 0),
    ("cpu_s", "run s", 1.0, 2),
)
"""Field, heading, factor, decimals."""
GLANCES = (
    ("Captured, %", ("success_rate",), 100.0, 0),
    ("Encircled at the capture, % of captures", ("encircled_at_capture_rate",), 100.0, 0),
    ("Time to the capture, median, s", ("capture_time_s",), 1.0, 1),
    ("Collided with an obstacle / with a teammate, %", ("hit_obstacle_rate", "hit_teammate_rate"), 100.0, 0),
    ("Least clearance to an obstacle / least distance of two pursuers, m", ("min_clearance_m", "min_separation_m"), 1.0, 2),
    ("Processor time of a decision, p50 / p99, us", ("decision_p50_us", "decision_p99_us"), 1.0, 0),
)
"""Heading, fields, factor, decimals: of each a table of scenarios and planners."""
NOTE = (
    "Success: captured without a collision, with its 95 % Wilson interval. Time, travel (sum over the team) and turning (sum of "
    "the changes of heading): medians over captures. Encircled: the evader inside the hull of the pursuers; share of the time: "
    "mean. Clearance and separation: the least of all runs, between surfaces and between centres. p50, p99: processor time of "
    "a decision; run: of a whole simulated run, mean."
)


def markdown_table(grid: Grid, figures: Sequence[Figures]) -> str:
    """Everything at a glance, then a table for each scenario."""
    parts = [
        "# All planners in all scenarios",
        f"{_runs(figures)} runs for each planner in each scenario; the same seeds for all.",
        "## Which to choose",
        aligned(HEADINGS, choices(grid, figures)),
        "As sure: the 95 % interval of its success overlaps that of the surest. "
        f"Planners with fewer than {RUNS_MIN} runs are left out.",
        "## All scenarios of a family together",
        *family_tables(grid, figures),
    ]
    for heading, fields, factor, decimals in GLANCES:
        parts += [f"## {heading}", glance(grid, figures, fields, factor, decimals)]
    parts.append(NOTE)
    for family, names in grid.families:
        parts.append(f"## {family}")
        for name in names:
            entries = [entry for entry in figures if entry["scenario"] == name]
            if entries:
                headings = ("planner", "runs", "95 % interval", *(heading for _, heading, _, _ in COLUMNS))
                parts += [f"### {name}", aligned(headings, [_cells(entry) for entry in entries])]
                parts += [f"{entry['planner']}: {entry['why']}" for entry in entries if entry["why"]]
    return "\n\n".join(parts) + "\n"


def glance(grid: Grid, figures: Sequence[Figures], fields: Sequence[str], factor: float, decimals: int) -> str:
    """Scenarios down, with the runs of each planner, planners across."""
    found = {(entry["scenario"], entry["planner"]): entry for entry in figures}
    rows = []
    for _, names in grid.families:
        for name in names:
            entries = [found.get((name, planner)) for planner in grid.planners]
            cells = [" / ".join(cell(entry, field, factor, decimals) for field in fields) for entry in entries]
            rows.append([name, _runs([entry for entry in entries if entry is not None]), *cells])
    return aligned(("scenario", "runs", *grid.planners), rows)


def cell(entry: Figures | None, field: str, factor: float, decimals: int) -> str:
    """One figure, or a dash."""
    value = None if entry is None else entry[field]
    return DASH if value is None else f"{round(factor * value, decimals) + 0.0:.{decimals}f}"  # no -0.00


def interval(entry: Figures) -> str:
    return f"{100.0 * entry['success_ci95_low']:.0f} to {100.0 * entry['success_ci95_high']:.0f}"


def csv_table(figures: Sequence[Figures]) -> str:
    """One row a planner and scenario, all figures, in SI units."""
    sink = io.StringIO()
    names = list(figures[0]) if figures else []
    writer = csv.DictWriter(sink, names, lineterminator="\n")
    writer.writeheader()
    writer.writerows(figures)
    return sink.getvalue()


def _runs(figures: Sequence[Figures]) -> str:
    counts = {entry["runs"] for entry in figures} or {0}
    return f"{min(counts)}" if len(counts) == 1 else f"{min(counts)} to {max(counts)}"


def _cells(entry: Figures) -> list[str]:
    figures = [cell(entry, field, factor, decimals) for field, _, factor, decimals in COLUMNS]
    return [entry["planner"], str(entry["runs"]), interval(entry), *figures]

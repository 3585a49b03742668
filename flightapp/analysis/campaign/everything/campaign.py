"""Fly what is missing of a grid, episode by episode, and write its table now and then."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import joblib

from flightapp.analysis.campaign.everything.curves import curve_pictures
from flightapp.analysis.campaign.everything.episode_row import Row, flown_row, planner_stamp, scenario_stamp
from flightapp.analysis.campaign.everything.figures import Figures, all_figures
from flightapp.analysis.campaign.everything.grid import Grid
from flightapp.analysis.campaign.everything.ledger import NAME, key_of, opened, read_rows
from flightapp.analysis.campaign.everything.page import page
from flightapp.analysis.campaign.everything.table import csv_table, markdown_table
from flightapp.analysis.campaign.progress import ProgressBar
from flightapp.analysis.campaign.workers import Workers, flown
from flightapp.analysis.summary import write_whole
from flightapp.core.errors import InputError
from flightapp.sim.batch.scenario import Scenario

CHUNK = 8
"""Episodes that a worker process flies before it hands them over."""


@dataclass(frozen=True, slots=True)
class Table:
    """What there is of the grid. `older`: planners with episodes that an older version of them flew, and how many."""

    folder: Path
    figures: list[Figures]
    markdown: str
    episodes: int
    wanted: int
    older: dict[str, int]

    @property
    def complete(self) -> bool:
        return self.episodes == self.wanted


def fly_everything(grid: Grid, folder: Path, workers: Workers, again: Sequence[str] = ()) -> Table:
    """Fly the episodes that the ledger in `folder` lacks, seed by seed over everything, and those of `again`: names of planners
    or scenarios. A person may stop it: what is flown is kept.
    """
    _check_again(grid, again)
    with opened(folder) as ledger:
        ledger.drop(lambda row: row["scenario"] in again or row["planner"] in again)
        _check_unchanged(grid, ledger.rows)
        jobs = _missing(grid, ledger.rows)
        total = _wanted(grid)
        try:
            with ProgressBar("everything", total, total - len(jobs)) as bar:
                last_seed = None
                for rows in _flown(jobs, workers):
                    ledger.add(rows)
                    bar.advance(len(rows), f"seed {rows[-1]['seed']}")
                    if rows[-1]["seed"] != last_seed:
                        last_seed = rows[-1]["seed"]
                        _write(grid, folder, ledger.rows)
        except KeyboardInterrupt:
            pass
        return _drawn(grid, _write(grid, folder, ledger.rows))


def show_everything(grid: Grid, folder: Path) -> Table:
    """The table of what is flown so far, also while another process flies."""
    rows = read_rows(folder / NAME)
    if not rows:
        raise InputError(f"--show: no episode in {folder / NAME}; fly some first, or name its folder with --output")
    return _drawn(grid, _write(grid, folder, rows))


def _check_again(grid: Grid, again: Sequence[str]) -> None:
    known = [*grid.planners, *(scenario.name for scenario in grid.scenarios)]
    for name in again:
        if name not in known:
            raise InputError(f"--again {name}: neither a planner nor a scenario of this table; it has {', '.join(known)}")


def _check_unchanged(grid: Grid, rows: Sequence[Row]) -> None:
    stamps = {scenario.name: scenario_stamp(scenario) for scenario in grid.scenarios}
    changed = sorted({row["scenario"] for row in rows if stamps.get(row["scenario"], row["of"]) != row["of"]})
    if changed:
        again = " ".join(f"--again {name}" for name in changed)
        raise InputError(
            f"scenarios have changed since they were flown: {', '.join(changed)}; add {again}, or name a new --output"
        )


def _missing(grid: Grid, rows: Sequence[Row]) -> list[tuple[Scenario, str, int]]:
    there = {key_of(row) for row in rows}
    return [
        (scenario, planner, seed)
        for seed in grid.seeds
        for scenario in grid.scenarios
        for planner in grid.planners
        if (scenario.name, planner, seed) not in there
    ]


def _wanted(grid: Grid) -> int:
    return len(grid.seeds) * len(grid.scenarios) * len(grid.planners)


def _flown(jobs: Sequence[tuple[Scenario, str, int]], workers: Workers) -> Iterator[list[Row]]:
    if workers.backend == "local" and workers.expected == 1:
        for job in jobs:
            yield [flown_row(*job)]
        return
    chunks = [jobs[start : start + CHUNK] for start in range(0, len(jobs), CHUNK)]
    yield from flown(workers, [joblib.delayed(_fly_chunk)(chunk) for chunk in chunks])


def _fly_chunk(jobs: Sequence[tuple[Scenario, str, int]]) -> list[Row]:
    return [flown_row(*job) for job in jobs]


def _write(grid: Grid, folder: Path, rows: Sequence[Row]) -> Table:
    """table.md, table.csv, table.json and table.html, each whole."""
    figures = all_figures(grid, rows)
    text = markdown_table(grid, figures)
    whole = json.dumps({"families": grid.families, "planners": grid.planners, "figures": figures}, indent=2) + "\n"
    write_whole(folder / "table.md", text.encode())
    write_whole(folder / "table.csv", csv_table(figures).encode())
    write_whole(folder / "table.json", whole.encode())
    write_whole(folder / "table.html", page(grid, figures).encode())
    older: dict[str, int] = {}
    for row in rows:
        if row["planner"] in grid.planners and row["by"] != planner_stamp(row["planner"]):
            older[row["planner"]] = older.get(row["planner"], 0) + 1
    return Table(folder, figures, text, sum(entry["runs"] for entry in figures), _wanted(grid), older)


def _drawn(grid: Grid, table: Table) -> Table:
    """The pictures beside `table`."""
    for name, picture in curve_pictures(grid.curves, grid.scenarios, grid.planners, table.figures):
        write_whole(table.folder / name, picture)
    return table

"""The control study on a terminal."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table

from flightapp.sim.control_study.campaign import FinishedStudy
from flightapp.sim.control_study.table import HEADINGS_1, HEADINGS_2, HEADINGS_3, cells_1, cells_2, cells_3

FAILED_MAX = 20
PIPED_WIDTH = 200
"""Columns where nobody says how wide the paper is."""


def print_control_study(finished: FinishedStudy) -> None:
    console = Console()
    if not console.is_terminal:
        console = Console(width=PIPED_WIDTH)
    rows = finished.rows
    first = rows[0].setting if rows else ""
    of_first = [row for row in rows if row.setting == first]
    for title, headings, lines in (
        ("table 1", HEADINGS_1, [cells_1(row) for row in rows]),
        (f"table 2: {first}", HEADINGS_2, [cells_2(row) for row in of_first]),
        (f"figures 16 to 18: {first}", HEADINGS_3, [cells_3(row) for row in of_first]),
    ):
        table = Table(title=title)
        for heading in headings:
            table.add_column(heading)
        for line in lines:
            table.add_row(*line)
        console.print(table)
    verdict = finished.acceptance
    console.print(verdict.sentence, markup=False, soft_wrap=True)
    for text in verdict.failed[:FAILED_MAX]:
        console.print(text, markup=False, soft_wrap=True)
    ended = "" if finished.complete else ", ended early"
    console.print(f"{len(finished.scenes)} scenes in {finished.seconds:.0f} s{ended}", markup=False)
    console.print(f"files: {finished.folder}", markup=False, soft_wrap=True)

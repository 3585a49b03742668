"""The control study on a terminal."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table

from flightapp.sim.control_study.campaign import FinishedStudy
from flightapp.sim.control_study.table import HEADINGS_1, HEADINGS_2, cells_1, cells_2

FAILED_MAX = 20


def print_control_study(finished: FinishedStudy) -> None:
    console = Console()
    rows = finished.rows
    first = rows[0].setting if rows else ""
    one, two = Table(title="table 1"), Table(title=f"table 2: {first}")
    for table, headings in ((one, HEADINGS_1), (two, HEADINGS_2)):
        for heading in headings:
            table.add_column(heading)
    for row in rows:
        one.add_row(*cells_1(row))
        if row.setting == first:
            two.add_row(*cells_2(row))
    console.print(one)
    console.print(two)
    verdict = finished.acceptance
    console.print(verdict.sentence, markup=False, soft_wrap=True)
    for text in verdict.failed[:FAILED_MAX]:
        console.print(text, markup=False, soft_wrap=True)
    ended = "" if finished.complete else ", ended early"
    console.print(f"{len(finished.scenes)} scenes in {finished.seconds:.0f} s{ended}", markup=False)
    console.print(f"files: {finished.folder}", markup=False, soft_wrap=True)

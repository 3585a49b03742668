"""The network campaign on a terminal."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table

from flightapp.sim.network_campaign.campaign import FinishedNetwork
from flightapp.sim.network_campaign.table import HEADINGS, cells

SHOWN_MAX = 40


def print_network_campaign(finished: FinishedNetwork) -> None:
    console = Console()
    table = Table(title="pursuits by network")
    for heading in HEADINGS:
        table.add_column(heading, justify="left" if heading == "partition" else "right")
    for row in finished.rows:
        table.add_row(*cells(row))
    console.print(table)
    for one in finished.real:
        console.print(one.sentence, markup=False, soft_wrap=True)
    violations = [f"seed {one.seed}, {one.condition}: {text}" for one in finished.flown for text in one.violations]
    for text in violations[:SHOWN_MAX]:
        console.print(text, markup=False, soft_wrap=True)
    if len(violations) > SHOWN_MAX:
        console.print(f"and {len(violations) - SHOWN_MAX} more in missions.json")
    ended = "" if finished.complete else ", ended early"
    told = f"{len(finished.flown)} missions in {finished.seconds:.0f} s{ended}, {len(violations)} violations"
    console.print(told, markup=False)
    console.print(f"files: {finished.folder}", markup=False, soft_wrap=True)

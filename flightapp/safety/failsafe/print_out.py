"""An explanation for a person and for machines."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table

from flightapp.safety.failsafe.explain import Explanation, sentence
from flightapp.safety.failsafe.table import HOW, Row


def print_explanation(found: Explanation) -> None:
    """The table's rows of the set conditions, then what wins."""
    table = Table(title=f"Failsafes that concern this, after {found.after_s:g} s")
    for heading in ("condition", "recognised by", "delay s", "action", "by", "in effect", "why"):
        table.add_column(heading)
    for row, in_effect in found.rows:
        cells = (f"{row.delay_s:g}", row.action.name, row.by, "yes" if in_effect else "no", row.why)
        table.add_row(row.condition, HOW[row.condition], *cells)
    console = Console(width=None if Console().is_terminal else 170)
    if found.rows:
        console.print(table)
    console.print(sentence(found), highlight=False)


def as_json(found: Explanation) -> dict[str, object]:
    """The same for machines."""
    rows = [{**_plain(row), "in_effect": in_effect} for row, in_effect in found.rows]
    row = found.verdict.row
    winner = None if row is None else _plain(row)
    return {"after_s": found.after_s, "state": found.verdict.state.name, "because": winner, "rows": rows}


def _plain(row: Row) -> dict[str, object]:
    return {
        "condition": row.condition,
        "how": HOW[row.condition],
        "delay_s": row.delay_s,
        "action": row.action.name,
        "why": row.why,
        "by": row.by,
        "pilot_may_override": row.pilot_may_override,
    }

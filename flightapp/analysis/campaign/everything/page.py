"""table.html: the table over everything as one file that needs no network; a click on a heading sorts."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from flightapp.analysis.campaign.everything.choice import HEADINGS, choices
from flightapp.analysis.campaign.everything.figures import Figures
from flightapp.analysis.campaign.everything.grid import Grid
from flightapp.analysis.campaign.everything.table import COLUMNS, NOTE, cell, interval

STYLE = """
body { font: 14px/1.4 system-ui, sans-serif; margin: 2rem; color: #222; background: #fff }
table { border-collapse: collapse; margin: 1rem 0 }
th, td { padding: .2rem .6rem; border-bottom: 1px solid #ddd; text-align: right; white-space: nowrap }
th:first-child, td:first-child { text-align: left }
th { position: sticky; top: 0; background: #fff; cursor: pointer; vertical-align: bottom }
td.why { white-space: normal; text-align: left; color: #666; max-width: 30rem }
p { max-width: 60rem }
"""
SCRIPT = """
for (const head of document.querySelectorAll("th")) head.addEventListener("click", () => {
  const body = head.closest("table").tBodies[0], at = [...head.parentNode.children].indexOf(head);
  const value = row => {
    const text = row.children[at].textContent, number = parseFloat(text);
    return isNaN(number) ? text : number;
  };
  const way = head.dataset.way = head.dataset.way === "1" ? "-1" : "1";
  const order = (a, b) => { const x = value(a), y = value(b);
    return typeof x === typeof y ? (x > y) - (x < y) : typeof x === "number" ? -1 : 1 };
  for (const row of [...body.rows].sort((a, b) => way * order(a, b))) body.append(row);
});
"""


def page(grid: Grid, figures: Sequence[Figures]) -> str:
    """Two tables at a glance, coloured, and one with everything."""
    found = {(entry["scenario"], entry["planner"]): entry for entry in figures}
    return "\n".join(
        [
            "<!doctype html>",
            '<html lang="en"><head><meta charset="utf-8"><title>All planners in all scenarios</title>',
            f"<style>{STYLE}</style></head><body>",
            "<h1>All planners in all scenarios</h1>",
            "<h2>Which to choose</h2>",
            _table(HEADINGS, [f"<tr><td>{'</td><td>'.join(map(escape, row))}</td></tr>" for row in choices(grid, figures)]),
            "<h2>Captured, %</h2>",
            _glance(grid, found, "success_rate"),
            "<h2>Encircled at the capture, % of captures</h2>",
            _glance(grid, found, "encircled_at_capture_rate"),
            f"<p>{escape(NOTE)}</p>",
            "<h2>Everything</h2>",
            _everything(figures),
            f"<script>{SCRIPT}</script></body></html>",
            "",
        ]
    )


def _glance(grid: Grid, found: dict[tuple[str, str], Figures], field: str) -> str:
    rows = []
    for _, names in grid.families:
        for name in names:
            cells = [_coloured(found.get((name, planner)), field) for planner in grid.planners]
            rows.append(f"<tr><td>{escape(name)}</td>{''.join(cells)}</tr>")
    return _table(("scenario", *grid.planners), rows)


def _coloured(entry: Figures | None, field: str) -> str:
    """From white to green."""
    value = None if entry is None else entry[field]
    shade = "" if value is None else f' style="background: rgba(46, 160, 67, {0.6 * value:.2f})"'
    return f"<td{shade}>{cell(entry, field, 100.0, 0)}</td>"


def _everything(figures: Sequence[Figures]) -> str:
    rows = []
    for entry in figures:
        cells = [escape(entry["scenario"]), escape(entry["planner"]), str(entry["runs"]), interval(entry)]
        cells += [cell(entry, field, factor, decimals) for field, _, factor, decimals in COLUMNS]
        rows.append(f'<tr><td>{"</td><td>".join(cells)}</td><td class="why">{escape(entry["why"])}</td></tr>')
    return _table(("scenario", "planner", "runs", "95 % interval", *(heading for _, heading, _, _ in COLUMNS), "why not"), rows)


def _table(headings: Sequence[str], rows: Sequence[str]) -> str:
    head = "".join(f"<th>{escape(heading)}</th>" for heading in headings)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table>"

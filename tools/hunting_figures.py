"""The hunting paper's tables beside what was flown: medians and ranges, from the episodes of `flightapp campaign all`.

    .venv/bin/flightapp campaign all missions/tables/hunting.toml --seeds 0-19 --output campaigns/hunting
    .venv/bin/python tools/hunting_figures.py campaigns/hunting

Exit status: 0 printed, 2 bad input.
"""

from __future__ import annotations

import argparse
import statistics
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from flightapp.analysis.campaign.everything.ledger import NAME, read_rows
from flightapp.core.errors import InputError

Row = dict[str, Any]
PAPER = {
    ("hunting-1-free", "tracking-hunting"): "table 2: yes, 1692.3 m, 126.7 rad",
    ("hunting-1-free", "hunting"): "table 2: yes, 1123.8 m, 36.1 rad",
    ("hunting-3-free", "tracking-hunting"): "table 4: no, 2088.5 m, 63.9 rad",
    ("hunting-3-free", "hunting"): "table 4: yes, 976.6 m, 44.7 rad",
    ("hunting-5-no-election", "hunting"): "table 6: no, 707.6 m, 20.5 rad",
    ("hunting-5-failures", "hunting"): "table 6: yes, 796.6 m, 22.8 rad",
    ("hunting-7-trap", "dwa"): "table 8: no, 1835.9 m, 178.9 rad",
    ("hunting-7-trap", "hunting"): "table 8: yes, 1346.2 m, 44.3 rad",
}
"""Of JMSE 13(2):221: success, travel and turning of the team, each of one run."""
HEADINGS = ("scenario", "planner", "captured", "time s", "travel m", "turning rad", "lost to", "the paper's")


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="of the campaign")
    folder = parser.parse_args().folder
    try:
        rows = read_rows(folder / NAME)
        if not rows:
            raise InputError(f"{folder}: no episodes; fly flightapp campaign all missions/tables/hunting.toml --output {folder}")
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    print("\n".join(table(rows)))
    return 0


def table(rows: Iterable[Row]) -> list[str]:
    """Markdown: a line a scenario and planner, the paper's scenes first. Travel, turning and time: median (least to greatest)."""
    runs: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        runs.setdefault((row["scenario"], row["planner"]), []).append(row)
    order = [*PAPER, *sorted(set(runs) - set(PAPER))]
    lines = [f"| {' | '.join(HEADINGS)} |", f"|{'---|' * len(HEADINGS)}"]
    return lines + [f"| {' | '.join(_cells(key, runs[key]))} |" for key in order if key in runs]


def _cells(key: tuple[str, str], runs: list[Row]) -> tuple[str, ...]:
    captured = [run for run in runs if run["outcome"] == "captured"]
    lost = {kind: sum(_loss(run) == kind for run in runs) for kind in sorted({_loss(run) for run in runs} - {""})}
    return (
        *key,
        f"{len(captured)} of {len(runs)}",
        _spread(captured, lambda run: run["duration_s"]),
        _spread(runs, lambda run: run["travel_m"]),
        _spread(runs, lambda run: run["turning_rad"]),
        ", ".join(f"{kind} {count}" for kind, count in lost.items()),
        PAPER.get(key, ""),
    )


def _loss(run: Row) -> str:
    outcome = str(run["outcome"])
    return "" if outcome == "captured" else f"collision ({run['collided_with']})" if outcome == "collided" else outcome


def _spread(runs: list[Row], value: Callable[[Row], float]) -> str:
    if not runs:
        return ""
    values = [value(run) for run in runs]
    return f"{statistics.median(values):.0f} ({min(values):.0f} to {max(values):.0f})"


if __name__ == "__main__":
    sys.exit(main())

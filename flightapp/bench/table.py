"""The result of a bench run for a person."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.table import Table


def print_bench(result: dict[str, Any]) -> None:
    """Print `result` of `run_bench` as a table, times in milliseconds."""
    about = result["machine"]
    loads = ", ".join(f"{load:.2f}" for load in about["load_average"])
    table = Table(title="Times in ms; the aim is for the 99th percentile")
    table.add_column("what", no_wrap=True)
    for heading in ("runs", "wall p50", "p99", "max", "CPU p50", "p99", "max", "aim", "verdict", "times faster"):
        table.add_column(heading, justify="right")
    for one in result["measurements"]:
        times = [f"{one[kind][name]:.3f}" for kind in ("wall_ms", "cpu_ms") for name in ("p50", "p99", "max")]
        aim = "" if one["aim_ms"] is None else f"{one['aim_ms']:g}"
        faster = "" if one["faster_by"] is None else f"{one['faster_by']:.1f}"
        table.add_row(one["name"], str(one["repetitions"]), *times, aim, one["verdict"], faster)
    console = Console(soft_wrap=False, width=None if Console().is_terminal else 150)
    console.print(f"{about['cpu']}, {about['cores']} cores, load average {loads}, Python {about['python']}", highlight=False)
    console.print(table)
    console.print(
        "Times faster: by median CPU time, than the same work in plain NumPy as one would first write it.", highlight=False
    )

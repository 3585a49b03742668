"""Live progress of a simulated mission: a table on a terminal, plain lines otherwise. Always on stderr."""

from __future__ import annotations

import sys
from collections.abc import Collection, Mapping
from types import TracebackType

from rich.console import Console
from rich.live import Live
from rich.table import Table

from flightapp.fleet.shared_state import SharedState

LINE_PERIOD_S = 2.0
FAILED = ("ended", "", "", "", "", "")
"""In place of phase, mode, distance, clearance, link age and guards."""


class Progress:
    """Shows mission time and, for each vehicle, phase, mode, distance to the evader, clearance, link age and acting guards."""

    def __init__(self, title: str) -> None:
        self._title = title
        self._console = Console(stderr=True)
        self._live = Live(console=self._console, refresh_per_second=8) if self._console.is_terminal else None
        self._last_line_s = -LINE_PERIOD_S
        self._last_phases: tuple[str, ...] = ()

    def __enter__(self) -> Progress:
        if self._live is not None:
            self._live.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None) -> None:
        if self._live is not None:
            self._live.stop()

    def show(self, elapsed_s: float, states: Mapping[str, SharedState], failed: Collection[str] = ()) -> None:
        """Show the newest state of every vehicle; lines at most every LINE_PERIOD_S, and at each change of phase.

        failed: vehicles whose process has ended with a fault. What they said last is not shown as if it went on.
        """
        rows = {name: FAILED if name in failed else _cells(state) for name, state in states.items()}
        if self._live is not None:
            self._live.update(self._table(elapsed_s, rows))
            return
        phases = tuple("/".join(cells[:2]) for cells in rows.values())
        if elapsed_s - self._last_line_s < LINE_PERIOD_S and phases == self._last_phases:
            return
        self._last_line_s, self._last_phases = elapsed_s, phases
        for name, cells in rows.items():
            self.say(f"{elapsed_s:6.1f} s  {name:<8} " + "  ".join(cells))

    def say(self, line: str) -> None:
        """One plain line."""
        if self._live is not None:
            self._console.print(line, highlight=False)
        else:
            sys.stderr.write(line + "\n")
            sys.stderr.flush()

    def _table(self, elapsed_s: float, rows: Mapping[str, tuple[str, ...]]) -> Table:
        table = Table(title=f"{self._title}   {elapsed_s:.1f} s", title_justify="left")
        for heading in ("vehicle", "phase", "mode", "to evader", "clearance", "link age", "guards"):
            table.add_column(heading)
        for name, cells in rows.items():
            table.add_row(name, *cells)
        return table


def _cells(state: SharedState) -> tuple[str, ...]:
    return (
        f"{state.phase:<9}",
        f"{state.mode:<9}" if state.mode != state.phase else f"{'-':<9}",
        _metres(state.target_distance_m),
        _metres(state.clearance_m),
        "    -   " if state.link_age_s is None else f"{state.link_age_s * 1e3:5.0f} ms",
        ",".join(state.guards),
    )


def _metres(value: float | None) -> str:
    return "    -  " if value is None else f"{value:5.1f} m"

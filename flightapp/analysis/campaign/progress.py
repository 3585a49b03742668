"""How far a long job is: a bar with the time left on a terminal, a line now and then otherwise. Always on stderr."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from types import TracebackType

from rich.console import Console, Group
from rich.live import Live
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.text import Text

from flightapp.core.clock import monotonic_ns
from flightapp.sim.batch.result import RunResult

LINE_PERIOD_S = 10.0


class ProgressBar:
    """A context that shows steps done of `total`, with running figures below."""

    def __init__(self, title: str, total: int, done: int = 0) -> None:
        self._title, self._total, self._done, self._done_first = title, total, done, done
        self._figures = ""
        console = Console(stderr=True)
        self._live: Live | None = None
        if console.is_terminal:
            self._bar = Progress(
                TextColumn("{task.description}"),
                BarColumn(bar_width=30),
                MofNCompleteColumn(),
                TimeElapsedColumn(),
                TextColumn("left"),
                TimeRemainingColumn(),
            )
            self._task = self._bar.add_task(title, total=total, completed=done)
            self._live = Live(get_renderable=lambda: Group(self._bar, Text(self._figures)), console=console)
        self._begun_ns = self._line_ns = monotonic_ns()

    def __enter__(self) -> ProgressBar:
        if self._live is not None:
            self._live.start(refresh=True)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None) -> None:
        if self._live is not None:
            self._live.stop()
        elif kind is None:
            self._line()

    def advance(self, steps: int, figures: str) -> None:
        """`steps` more are done; `figures` is what is known now."""
        self._done += steps
        self._figures = figures
        if self._live is not None:
            self._bar.update(self._task, completed=self._done)
        elif monotonic_ns() - self._line_ns > LINE_PERIOD_S * 1e9:
            self._line()

    def _line(self) -> None:
        self._line_ns = monotonic_ns()
        elapsed_s = (self._line_ns - self._begun_ns) * 1e-9
        fresh = self._done - self._done_first
        left = f", {elapsed_s * (self._total - self._done) / fresh:.0f} s left" if fresh > 0 and self._done < self._total else ""
        sys.stderr.write(f"{self._title}: {self._done} of {self._total} in {elapsed_s:.0f} s{left}  {self._figures}\n")
        sys.stderr.flush()


class Successes:
    """Running share of captures of each planner."""

    def __init__(self, planners: Sequence[str]) -> None:
        self._counts = {planner: [0, 0] for planner in planners}

    def add(self, results: Sequence[RunResult]) -> str:
        """The figures with `results` counted in."""
        for result in results:
            counts = self._counts[result.planner]
            counts[0] += result.outcome == "captured"
            counts[1] += 1
        shares = (f"{name} {100 * good / runs:.1f} %" for name, (good, runs) in self._counts.items() if runs)
        return "captured: " + ", ".join(shares)

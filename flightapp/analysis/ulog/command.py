"""What `flightapp report` was asked for: one log of PX4, or recordings."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from flightapp.analysis.ulog.report import SUFFIX, report_log
from flightapp.core.errors import InputError

__all__ = ["log_among", "report_log"]


def log_among(paths: Sequence[Path], output: Path | None) -> Path | None:
    """The one log of PX4 that was named; None if recordings were. InputError for a mixture, or --output without a log."""
    logs = [path for path in paths if path.suffix.lower() == SUFFIX]
    if not logs:
        if output is not None:
            raise InputError("--output: only for a log of PX4 (.ulg); the report of a run goes into its folder")
        return None
    if len(paths) > 1:
        raise InputError(f"{logs[0]}: name one .ulg alone, or put it into the run folder and name that")
    return logs[0]

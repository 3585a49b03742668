"""What a network campaign measured, a row a condition: for terminals, spreadsheets and documents."""

from __future__ import annotations

import csv
import io
import statistics
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass

from flightapp.analysis.campaign.statistics import wilson_interval
from flightapp.sim.network_campaign.conditions import Condition
from flightapp.sim.network_campaign.flight import Flown


@dataclass(frozen=True, slots=True)
class Row:
    """Medians over the missions of one condition, but the smallest separation and the sums of changes and violations."""

    partition: str
    delay_ms: float
    jitter_ms: float
    loss_percent: float
    missions: int
    captured: int
    captured_low: float
    captured_high: float
    """Share of captures: Wilson's 95 % interval."""
    capture_time_s: float | None
    separation_min_m: float | None
    age_p50_ms: float | None
    age_p99_ms: float | None
    leader_changes: int
    violations: int

    def as_json(self) -> dict[str, object]:
        return asdict(self)


def rows_of(flown: Sequence[Flown]) -> list[Row]:
    """By partition, delay and loss."""
    conditions = sorted({one.condition for one in flown})
    return [_row(condition, [one for one in flown if one.condition == condition]) for condition in conditions]


def _row(condition: Condition, flown: Sequence[Flown]) -> Row:
    captured = sum(one.captured for one in flown)
    low, high = wilson_interval(captured, len(flown))
    return Row(
        partition=condition.partition,
        delay_ms=condition.delay_ms,
        jitter_ms=condition.jitter_ms,
        loss_percent=condition.loss_percent,
        missions=len(flown),
        captured=captured,
        captured_low=round(low, 3),
        captured_high=round(high, 3),
        capture_time_s=_of(statistics.median, [one.capture_time_s for one in flown]),
        separation_min_m=_of(min, [one.separation_min_m for one in flown]),
        age_p50_ms=_of(statistics.median, [one.age_p50_ms for one in flown]),
        age_p99_ms=_of(statistics.median, [one.age_p99_ms for one in flown]),
        leader_changes=sum(one.leader_changes for one in flown),
        violations=sum(len(one.violations) for one in flown),
    )


def _of(function: Callable[[list[float]], float], values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return round(function(known), 3) if known else None


def as_csv(rows: Sequence[Row]) -> str:
    sink = io.StringIO()
    writer = csv.DictWriter(sink, list(rows[0].as_json()), lineterminator="\n")
    writer.writeheader()
    writer.writerows(row.as_json() for row in rows)
    return sink.getvalue()


HEADINGS = (
    "partition",
    "delay ms",
    "loss %",
    "captured",
    "after s",
    "separation m",
    "age p50 ms",
    "age p99 ms",
    "leader changes",
    "violations",
)


def cells(row: Row) -> tuple[str, ...]:
    """One a heading."""
    return (
        row.partition,
        f"{row.delay_ms:g} +- {row.jitter_ms:g}",
        f"{row.loss_percent:g}",
        f"{row.captured}/{row.missions}",
        _number(row.capture_time_s, 1),
        _number(row.separation_min_m, 2),
        _number(row.age_p50_ms, 0),
        _number(row.age_p99_ms, 0),
        str(row.leader_changes),
        str(row.violations),
    )


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


def as_markdown(rows: Sequence[Row]) -> str:
    lines = [HEADINGS, ("---",) * len(HEADINGS), *map(cells, rows)]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)

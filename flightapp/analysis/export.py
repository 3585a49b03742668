"""All series of a run as one table: CSV for everybody, Parquet for tools. One row a step of one time base."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
from pyarrow import csv, parquet

from flightapp.analysis.map_data import origin_name, origin_s
from flightapp.analysis.run import Run, VehicleRun
from flightapp.analysis.signals import Signal, signals_of
from flightapp.analysis.spells import Spell, guard_spells, mode_spells, phase_spells
from flightapp.analysis.track import Track
from flightapp.core.types import Array

STEP_S = 0.04
"""25 Hz, the rate of the control loop."""
_HELD_S = 1.0
"""A value is the newest one, but none older than this, or than three times what its series usually leaves between two."""


def table_of(run: Run, signals: Sequence[Signal] | None = None) -> pa.Table:
    """Columns `t_s` (fleet time), `since_pursuit_s` (or `since_recording_s`), then `VEHICLE.QUANTITY_UNIT`; null: not known."""
    signals = signals_of(run) if signals is None else signals
    t_s = _time_base(run)
    columns: dict[str, pa.Array] = {"t_s": pa.array(t_s), f"since_{origin_name(run)}_s": pa.array(t_s - origin_s(run))}
    for vehicle in run.vehicles:
        columns |= {name: _numbers(values) for name, values in _motion(vehicle, t_s)}
        for name, spells in (("phase", phase_spells(vehicle)), ("mode", mode_spells(vehicle)), ("guards", guard_spells(vehicle))):
            columns[f"{vehicle.name}.{name}"] = pa.array(_texts(spells, t_s), pa.string())
    for signal in signals:
        columns[signal.column] = _numbers(held(signal.t_s, signal.values, t_s))
    return pa.table(columns)


def write_csv(run: Run, table: pa.Table) -> Path:
    """`series.csv` where the run's results belong; whole or not at all."""
    path = run.output("series.csv")
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        csv.write_csv(table, temporary)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
    return path


def write_parquet(run: Run, table: pa.Table) -> Path:
    """`series.parquet` where the run's results belong; whole or not at all."""
    path = run.output("series.parquet")
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        parquet.write_table(table, temporary, compression="zstd")
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
    return path


def held(known_t_s: Array, values: Array, t_s: Array) -> Array:
    """The newest value at each of the times `t_s`; NaN before the first and once it is too old."""
    if len(known_t_s) == 0:
        return np.full(len(t_s), np.nan)
    newest = np.searchsorted(known_t_s, t_s, side="right") - 1
    usual_s = float(np.median(np.diff(known_t_s))) if len(known_t_s) > 1 else 0.0
    chosen = np.maximum(newest, 0)
    is_known = (newest >= 0) & (t_s - known_t_s[chosen] <= max(_HELD_S, 3.0 * usual_s))
    return np.asarray(np.where(is_known, values[chosen], np.nan), dtype=np.float64)


def _time_base(run: Run) -> Array:
    starts = [float(series.t_s[0]) for v in run.vehicles for series in v.recording.series.values() if len(series)]
    start_s = min(starts, default=0.0)
    end_s = max((vehicle.phases.end_s for vehicle in run.vehicles), default=start_s)
    count = int(max(0.0, end_s - start_s) / STEP_S) + 1
    return np.linspace(start_s, start_s + STEP_S * (count - 1), count)


def _motion(vehicle: VehicleRun, t_s: Array) -> Iterator[tuple[str, Array]]:
    """What the vehicle knew of itself, what was true, and where it believed the evader to be."""
    if vehicle.own is not None:
        yield from _way(vehicle.name, vehicle.own, t_s)
    if vehicle.truth is not None:
        yield from _way(f"{vehicle.name}.true", vehicle.truth, t_s)
    target = vehicle.recording.topic("/target")
    if len(target):
        position = target.vectors("position_ned_m")
        for axis, direction in enumerate(("north", "east", "down")):
            yield f"{vehicle.name}.target_{direction}_m", held(target.t_s, position[:, axis], t_s)


def _way(name: str, track: Track, t_s: Array) -> Iterator[tuple[str, Array]]:
    inside = (t_s >= track.t_s[0]) & (t_s <= track.t_s[-1])
    there = track.at(t_s)
    for axis, direction in enumerate(("north", "east", "down")):
        yield f"{name}.{direction}_m", np.where(inside, there.position_ned_m[:, axis], np.nan)
        yield f"{name}.velocity_{direction}_m_s", np.where(inside, there.velocity_ned_m_s[:, axis], np.nan)


def _numbers(values: Array) -> pa.Array:
    return pa.array(values, mask=~np.isfinite(values))


def _texts(spells: Sequence[Spell], t_s: Array) -> list[str | None]:
    """What holds at each time; names of several at once with a semicolon between them."""
    texts: list[str | None] = [None] * len(t_s)
    for spell in spells:
        first, last = np.searchsorted(t_s, (spell.from_s, spell.to_s))
        for index in range(int(first), max(int(last), min(int(first) + 1, len(t_s)))):
            known = texts[index]
            texts[index] = spell.name if known is None else known if spell.name in known.split(";") else f"{known};{spell.name}"
    return texts

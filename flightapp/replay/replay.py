"""Decide recordings again: the ones of a run folder, or a single one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import orjson

from flightapp.core.errors import InputError
from flightapp.planning.registry import evader_names, planner_names
from flightapp.recording.small_log import SUFFIX as SMALL_SUFFIX
from flightapp.replay.deciding import decide
from flightapp.replay.difference import difference
from flightapp.replay.flight import Flight, read_flight
from flightapp.replay.open_loop import compared, what_if
from flightapp.replay.outcome import Replayed
from flightapp.replay.strategy import strategy_of

TRUTH_STEM = "truth"


@dataclass(frozen=True, slots=True)
class Wanted:
    """What is asked: only `vehicle`; another `planner` or other `parameters` than flew; differences beyond `tolerance`."""

    run: Path
    vehicle: str | None = None
    planner: str | None = None
    parameters: Path | None = None
    tolerance: float = 0.0


@dataclass(frozen=True, slots=True)
class Answer:
    """All vehicles that could be decided again, and (file, why) of those that could not."""

    replayed: tuple[Replayed, ...]
    left_out: tuple[tuple[Path, str], ...]

    @property
    def identical(self) -> bool:
        return all(one.identical for one in self.replayed)

    def summary(self) -> dict[str, object]:
        """Plain JSON values."""
        return {
            "identical": self.identical,
            "vehicles": [one.summary() for one in self.replayed],
            "left_out": [{"file": str(path), "reason": reason} for path, reason in self.left_out],
        }

    def text(self) -> str:
        return "\n".join([*(one.text() for one in self.replayed), *(f"left out: {reason}" for _, reason in self.left_out)])

    def write(self, path: Path) -> None:
        """Summary and every difference as JSON; InputError if the file cannot be written."""
        vehicles = [{**one.summary(), "differences": one.all_differences()} for one in self.replayed]
        try:
            path.write_bytes(orjson.dumps({**self.summary(), "vehicles": vehicles}, option=orjson.OPT_INDENT_2))
        except OSError as error:
            raise InputError(f"--out {path}: cannot be written: {error.strerror}") from None


def replay(wanted: Wanted) -> Answer:
    """Decide again what `wanted` names. InputError where nothing of it can be, or where a file named by itself cannot."""
    if wanted.planner is not None and wanted.planner not in (*planner_names(), *evader_names()):
        known = ", ".join((*planner_names(), *evader_names()))
        raise InputError(f"--planner {wanted.planner}: no such planner or evader policy; known: {known}")
    if not wanted.run.is_dir():
        return Answer((_replayed(read_flight(wanted.run), wanted),), ())
    replayed: list[Replayed] = []
    left_out: list[tuple[Path, str]] = []
    for path in _files(wanted.run):
        try:
            flight = read_flight(path)
            if wanted.vehicle not in (None, flight.vehicle.name):
                continue
            if wanted.planner is not None and wanted.planner not in _strategies(flight):
                left_out.append((path, f"{path}: '{wanted.planner}' is not for the {flight.vehicle.role} {flight.vehicle.name}"))
                continue
            replayed.append(_replayed(flight, wanted))
        except InputError as error:
            left_out.append((path, str(error)))
    if not replayed:
        missing = (
            f"{wanted.run}: has no recording of '{wanted.vehicle}'" if wanted.vehicle else f"{wanted.run}: nothing to decide"
        )
        raise InputError(left_out[0][1] if left_out else missing)
    return Answer(tuple(replayed), tuple(left_out))


def _files(folder: Path) -> Sequence[Path]:
    """Recordings of vehicles; the decimated logs beside them do not hold what was decided on."""
    every = sorted(folder.glob("*.mcap"))
    files = [path for path in every if path.stem != TRUTH_STEM and not path.name.endswith(SMALL_SUFFIX)]
    if not files:
        raise InputError(f"{folder}: no recording (.mcap) in this folder")
    return files


def _strategies(flight: Flight) -> tuple[str, ...]:
    return evader_names() if flight.vehicle.role == "evader" else planner_names()


def _replayed(flight: Flight, wanted: Wanted) -> Replayed:
    if wanted.vehicle not in (None, flight.vehicle.name):
        raise InputError(f"{flight.recording.path}: is of '{flight.vehicle.name}', not of '{wanted.vehicle}'")
    planner = strategy_of(flight, wanted.planner, wanted.parameters)
    is_another = wanted.planner is not None or wanted.parameters is not None
    differences, decisions = [], []
    for tick, now in decide(flight, planner):
        found = difference(tick, now, wanted.tolerance)
        if found is not None:
            differences.append(found)
        pair = compared(tick, now) if is_another else None
        if pair is not None:
            decisions.append(pair)
    ticks = flight.ticks
    return Replayed(
        file=str(flight.recording.path),
        vehicle=flight.vehicle.name,
        strategy=wanted.planner or flight.vehicle.strategy.name,
        complete=flight.recording.complete,
        start_s=ticks[0].t_s,
        duration_s=ticks[-1].t_s - ticks[0].t_s,
        decisions=sum(tick.planned for tick in ticks),
        setpoints=sum(tick.sent is not None for tick in ticks),
        skipped=sum(tick.given is None for tick in ticks),
        differences=tuple(differences),
        what_if=what_if(decisions) if is_another else {},
    )

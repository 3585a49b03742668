"""`flightapp bench tracking`: the target filter against recorded flights, beside the constant-velocity filter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from flightapp.bench.machine import machine
from flightapp.core.clock import thread_cpu_ns
from flightapp.estimation.consistency import (
    AHEAD_S,
    CONSTANT_VELOCITY,
    Circumstances,
    Flight,
    judge,
    measurements_of,
    read_flight,
)
from flightapp.estimation.target_filter import TargetFilter, TargetFilterParameters

FILTERS = {"1 model": CONSTANT_VELOCITY, "3 models": TargetFilterParameters()}
COST_MEASUREMENTS_MIN = 4000


def run_tracking(tracks: Sequence[Path], seed: int, slowed: float) -> dict[str, Any]:
    """Judge both filters on each of `tracks`, flown `slowed` times slower; plain values, for JSON."""
    flights = [read_flight(path, slowed) for path in tracks]
    judged = {name: [judge(flight, filtered, seed=seed) for flight in flights] for name, filtered in FILTERS.items()}
    return {
        "machine": machine(),
        "seed": seed,
        "slowed": slowed,
        "circumstances": asdict(Circumstances()),
        "flights": [
            {"filter": name, **asdict(consistency)}
            for pair in zip(*judged.values(), strict=True)
            for name, consistency in zip(judged, pair, strict=True)
        ],
        "update_cpu_ms": _cost_ms(flights[0], seed),
    }


def _cost_ms(flight: Flight, seed: int) -> dict[str, float]:
    """CPU time of one update with a full ring, measurements up to 0.3 s late among them."""
    target = TargetFilter()
    spent: list[float] = []
    arrivals = sorted(measurements_of(flight, Circumstances(), (), np.random.default_rng(seed)), key=lambda pair: pair[0])
    while len(spent) < COST_MEASUREMENTS_MIN:
        target.reset()
        for _, measurement in arrivals:
            started_ns = thread_cpu_ns()
            target.take(measurement)
            spent.append((thread_cpu_ns() - started_ns) * 1e-6)
    p50, p99 = np.percentile(spent, (50, 99)).tolist()
    return {"p50": p50, "p99": p99, "max": max(spent)}


def print_tracking(result: dict[str, Any]) -> None:
    """Print `result` of `run_tracking`."""
    console = Console(width=None if Console().is_terminal else 150)
    table = Table(title="Target filter on recorded flights: loss, delay, sighting noise, occlusions")
    table.add_column("flight", overflow="fold")
    table.add_column("filter", overflow="fold")
    for heading in ("NEES", "95 % bounds", "inside", "hidden", "inside", "NIS", "position m", "velocity m/s"):
        table.add_column(heading, justify="right")
    for ahead_s in AHEAD_S:
        table.add_column(f"+{ahead_s:g} s, m", justify="right")
    for row in result["flights"]:
        low, high = row["nees_bounds"]
        table.add_row(
            row["flight"],
            row["filter"],
            f"{row['nees']:.1f}",
            f"{low:.1f} to {high:.1f}",
            f"{100 * row['inside']:.0f} %",
            f"{row['nees_hidden']:.1f}",
            f"{100 * row['inside_hidden']:.0f} %",
            f"{row['nis']:.2f}",
            f"{row['position_rms_m']:.2f}",
            f"{row['velocity_rms_m_s']:.2f}",
            *(f"{ahead:.2f}" for ahead in row["ahead_rms_m"]),
        )
    console.print(table)
    cost = result["update_cpu_ms"]
    console.print(
        f"one update, CPU time: p50 {cost['p50']:.3f} ms, p99 {cost['p99']:.3f} ms, max {cost['max']:.3f} ms", highlight=False
    )
    console.print(
        "NEES: 6 of a consistent filter, more says too sure, less says too careful; inside: errors in the 95 % ellipsoid; "
        "hidden: while nothing is told or seen.",
        highlight=False,
    )

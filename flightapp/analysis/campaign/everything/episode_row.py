"""One flown episode as a line of the ledger: plain JSON values."""

from __future__ import annotations

import hashlib
import importlib.util
import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from flightapp.core.clock import thread_ns
from flightapp.core.errors import InputError
from flightapp.planning.registry import PLANNERS
from flightapp.sim.batch.episode import fly
from flightapp.sim.batch.result import RunResult
from flightapp.sim.batch.scenario import Scenario

Row = dict[str, Any]

REFUSED, BROKEN = "refused", "broken"
"""Outcomes of what did not fly: the planner or the layout says why not; an error in the planner."""
WHY_MAX = 300
FIELDS = (
    "outcome",
    "collided_with",
    "duration_s",
    "capture_time_s",
    "boundary_distance_m",
    "min_clearance_m",
    "min_separation_m",
    "encircled_first_s",
    "encircled_share",
    "encircled_at_capture",
    "travel_m",
    "turning_rad",
    "lost",
)
"""Of a result, as they are."""
BINS_A_DECADE = 40
"""Of the histogram of decision times: a quantile from it is right within 3 %."""


def flown_row(scenario: Scenario, planner: str, seed: int) -> Row:
    """Fly it. What goes wrong is a row, too: the others go on."""
    stamps = {"of": scenario_stamp(scenario), "by": planner_stamp(planner)}
    head = {"scenario": scenario.name, "planner": planner, "seed": seed, **stamps}
    began_ns = thread_ns()
    try:
        return {**head, **_figures(fly(scenario, planner, seed)), "cpu_s": round((thread_ns() - began_ns) * 1e-9, 4)}
    except InputError as refusal:
        return {**head, "outcome": REFUSED, "why": str(refusal)[:WHY_MAX]}
    except Exception as error:
        return {**head, "outcome": BROKEN, "why": f"{type(error).__name__}: {error}"[:WHY_MAX]}


def scenario_stamp(scenario: Scenario) -> str:
    """Changes with anything in the scenario."""
    return hashlib.sha256(scenario.model_dump_json().encode()).hexdigest()[:12]


@cache
def planner_stamp(planner: str) -> str:
    """Changes with the source in the folder of the strategy `planner`."""
    found = importlib.util.find_spec(PLANNERS[planner])
    if found is None or found.origin is None:
        return ""
    sources = sorted(Path(found.origin).parent.rglob("*.py"))
    return hashlib.sha256(b"\0".join(source.read_bytes() for source in sources)).hexdigest()[:12]


def _figures(result: RunResult) -> Row:
    figures = {name: _finite(getattr(result, name)) for name in FIELDS}
    return {**figures, "decision_histogram": histogram(result.decision_ns)}


def _finite(value: object) -> object:
    """JSON knows no infinity: None. Ten digits are enough for a table."""
    if isinstance(value, float):
        return float(f"{value:.10g}") if math.isfinite(value) else None
    return value


def histogram(decision_ns: np.ndarray) -> dict[str, int]:
    """{number of the bin: decisions in it}; bins are even in the logarithm, from 1 ns."""
    numbers = np.floor(np.log10(np.maximum(decision_ns, 1)) * BINS_A_DECADE).astype(np.int64)
    values, counts = np.unique(numbers, return_counts=True)
    return {str(value): count for value, count in zip(values.tolist(), counts.tolist(), strict=True)}


def quantile_us(bins: dict[int, int], share: float) -> float | None:
    """The quantile of merged histograms, at the middle of its bin."""
    total, passed = sum(bins.values()), 0
    for number in sorted(bins):
        passed += bins[number]
        if passed >= share * total:
            return float(10.0 ** ((number + 0.5) / BINS_A_DECADE) * 1e-3)
    return None

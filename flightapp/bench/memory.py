"""Whether one planner that decides again and again takes ever more memory."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flightapp.bench.situation import far, near
from flightapp.core.types import Limits
from flightapp.planning.registry import make_planner

MIB = 2.0**20
WARM_UP_SHARE = 0.1
"""Histories and caches fill in this part of the steps: it does not count."""
SAMPLES = 200
LEG = 300
"""Periods of straight flight, then of circling near the evader: every stage is left and entered again."""
CONFINED_M2 = 2.0
"""Between the variance of the circling (1) and of the straight flight (3): the circling is taken for a trap."""
GROWTH_MAX_MIB = 1.0


@dataclass(frozen=True, slots=True)
class MemoryUse:
    """Resident set before, after the warm-up and at the end; the slope is a fitted line's after the warm-up."""

    steps: int
    before_mib: float
    warm_mib: float
    after_mib: float
    slope_bytes_per_step: float
    modes: dict[str, int]
    """Steps in each mode."""

    @property
    def verdict(self) -> str:
        return "flat" if self.after_mib - self.warm_mib < GROWTH_MAX_MIB else "grows"


def memory_use(limits: Limits, steps: int) -> MemoryUse:
    """Step one planner `steps` times through changing situations."""
    planner = make_planner("ac2f", limits=limits, parameters={"oscillation_variance_m2": CONFINED_M2})
    every = max(1, steps // SAMPLES)
    modes: dict[str, int] = {}
    taken, resident = [], []
    before = resident_mib()
    for k in range(steps):
        mode = planner.step(near(k) if k // LEG % 2 else far(k)).mode
        modes[mode] = modes.get(mode, 0) + 1
        if k % every == 0 and k >= WARM_UP_SHARE * steps:
            taken.append(k)
            resident.append(resident_mib())
    after = resident_mib()
    slope = float(np.polyfit(taken, np.array(resident) * MIB, 1)[0]) if len(taken) > 1 else 0.0
    return MemoryUse(steps, before, resident[0], after, slope, modes)


def resident_mib() -> float:
    """Resident set of this process."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / MIB

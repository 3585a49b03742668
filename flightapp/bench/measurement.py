"""Repeated timing of one piece of work, in wall time and in CPU time of the calling thread."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from flightapp.core.clock import monotonic_ns, thread_cpu_ns
from flightapp.core.types import Array

T = TypeVar("T")

REPETITIONS_MIN = 20


@dataclass(frozen=True, slots=True)
class Work(Generic[T]):
    """What is measured: `prepare` makes the input of repetition k, outside the measured time; `act` is measured.

    aim_ms: the 99th percentile should stay below. warm_up: repetitions that do not count. pause_s: idle time between
    repetitions, where work in other threads must keep up.
    """

    name: str
    prepare: Callable[[int], T]
    act: Callable[[T], object]
    aim_ms: float | None = None
    warm_up: int = 5
    pause_s: float = 0.0


@dataclass(frozen=True, slots=True)
class Percentiles:
    """Milliseconds."""

    p50: float
    p99: float
    max: float

    @classmethod
    def of(cls, times_ms: Array) -> Percentiles:
        """Percentiles of (n,) durations."""
        return cls(*(float(value) for value in np.percentile(times_ms, (50, 99, 100))))


@dataclass(frozen=True, slots=True)
class Measurement:
    """Times of one piece of work.

    faster_by: median CPU time of its plain reference over its own, where there is one. orca_ratio: the same, of a decision of
    ORCA. sdk_ratio: the same, of the RealSense SDK's decimation and point cloud.
    """

    name: str
    repetitions: int
    wall_ms: Percentiles
    cpu_ms: Percentiles
    aim_ms: float | None
    faster_by: float | None = None
    orca_ratio: float | None = None
    sdk_ratio: float | None = None

    @property
    def verdict(self) -> str:
        """How the 99th percentile compares with the aim: a busy machine adds to wall time but hardly to CPU time."""
        if self.aim_ms is None:
            return ""
        if self.wall_ms.p99 < self.aim_ms:
            return "met"
        return "met in CPU time" if self.cpu_ms.p99 < self.aim_ms else "missed"


def measure(work: Work[T], seconds: float) -> Measurement:
    """Repeat `work` for about `seconds`, at least REPETITIONS_MIN times."""
    wall: list[int] = []
    cpu: list[int] = []
    end_ns = monotonic_ns() + round(seconds * 1e9)
    k = 0
    while k < work.warm_up + REPETITIONS_MIN or monotonic_ns() < end_ns:
        given = work.prepare(k)
        if work.pause_s > 0.0:
            time.sleep(work.pause_s)
        wall_ns, cpu_ns = monotonic_ns(), thread_cpu_ns()
        work.act(given)
        cpu_ns, wall_ns = thread_cpu_ns() - cpu_ns, monotonic_ns() - wall_ns
        if k >= work.warm_up:
            wall.append(wall_ns)
            cpu.append(cpu_ns)
        k += 1
    return Measurement(
        work.name, len(wall), Percentiles.of(np.array(wall) * 1e-6), Percentiles.of(np.array(cpu) * 1e-6), work.aim_ms
    )

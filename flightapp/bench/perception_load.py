"""Perception without a pause: how many frames one core takes, and whether memory grows meanwhile."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flightapp.bench.camera import pipeline_of
from flightapp.bench.depth_flight import depth_flight, wood_between_walls
from flightapp.bench.memory import GROWTH_MAX_MIB, MIB, SAMPLES, WARM_UP_SHARE, resident_mib
from flightapp.config.profile import Profile
from flightapp.core.clock import monotonic_ns, thread_cpu_ns

RATE_AIM_HZ = 90.0
FRAMES_AN_HOUR = 108_000
"""At 30 Hz."""


@dataclass(frozen=True, slots=True)
class FrameRate:
    """Frames over wall time and over CPU time of the thread, in a wood between walls."""

    frames: int
    frames_per_s: float
    frames_per_cpu_s: float
    aim: float = RATE_AIM_HZ

    @property
    def verdict(self) -> str:
        """How the rate compares with the aim: a busy machine takes wall time but hardly CPU time."""
        if self.frames_per_s >= self.aim:
            return "met"
        return "met in CPU time" if self.frames_per_cpu_s >= self.aim else "missed"


@dataclass(frozen=True, slots=True)
class FrameMemory:
    """Resident set before, after the warm-up and at the end; the slope is a fitted line's after the warm-up.

    hour_mib: what that slope comes to in an hour at 30 Hz.
    """

    frames: int
    before_mib: float
    warm_mib: float
    after_mib: float
    slope_bytes_per_frame: float
    hour_mib: float

    @property
    def verdict(self) -> str:
        return "flat" if self.after_mib - self.warm_mib < GROWTH_MAX_MIB else "grows"


def perception_load(profile: Profile, frames: int) -> tuple[FrameRate, FrameMemory]:
    """`frames` frames, one right after the other. FRAMES_AN_HOUR of them are an hour's flight."""
    flight, pipeline = depth_flight(wood_between_walls(), profile.camera, 0.0, 0.0), pipeline_of(profile, 0.0)
    every = max(1, frames // SAMPLES)
    taken, resident = [], []
    before = resident_mib()
    began_ns, began_cpu_ns = monotonic_ns(), thread_cpu_ns()
    for k in range(frames):
        pipeline.process(*flight.shot(k))
        if k % every == 0 and k >= WARM_UP_SHARE * frames:
            taken.append(k)
            resident.append(resident_mib())
    wall_s, cpu_s = (monotonic_ns() - began_ns) * 1e-9, (thread_cpu_ns() - began_cpu_ns) * 1e-9
    after = resident_mib()
    slope = float(np.polyfit(taken, np.array(resident) * MIB, 1)[0]) if len(taken) > 1 else 0.0
    rate = FrameRate(frames, frames / wall_s, frames / cpu_s)
    return rate, FrameMemory(frames, before, resident[0], after, slope, slope * FRAMES_AN_HOUR / MIB)

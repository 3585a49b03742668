"""Depth frames to obstacles in a thread of their own; the newest result waits in a slot for the control loop."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flightapp.core.clock import Clock
from flightapp.core.types import Array, ObstacleSet
from flightapp.vehicle.pose_history import PoseHistory
from perception.pipeline import PerceptionPipeline
from perception.sources import DepthSource
from perception.types import VehiclePose

POLL_PERIOD_S = 0.002


@dataclass(frozen=True, slots=True)
class Perceived:
    """Result of one frame: obstacles in the mission frame, when it was captured and what it cost."""

    obstacles: ObstacleSet
    frame_s: float
    frame_number: int
    latency_s: float
    skipped: int
    events: tuple[str, ...]


class PerceptionThread(threading.Thread):
    """Takes the newest frame, finds its pose, extracts discs, then wakes the control loop with `on_result`."""

    def __init__(
        self,
        source: DepthSource,
        pipeline: PerceptionPipeline,
        history: PoseHistory,
        clock: Clock,
        on_result: Callable[[], None],
    ) -> None:
        super().__init__(name="perception", daemon=True)
        self._source = source
        self._pipeline = pipeline
        self._history = history
        self._clock = clock
        self._on_result = on_result
        self._stopping = threading.Event()
        self.newest: Perceived | None = None
        self.failure: str | None = None
        self.exclude: Array = np.zeros((0, 3))
        """Rows north_m, east_m, radius_m of vehicles that must not become obstacles."""

    def run(self) -> None:
        try:
            while not self._stopping.is_set():
                if not self._take_one():
                    self._stopping.wait(POLL_PERIOD_S)
        except Exception as error:  # A dead camera thread must become an event, not a silent loss.
            self.failure = f"{type(error).__name__}: {error}"

    def stop(self) -> None:
        self._stopping.set()
        if self.is_alive():
            self.join(timeout=1.0)
        self._source.close()

    def _take_one(self) -> bool:
        frame = self._source.latest()
        if frame is None:
            return False
        motion = self._history.at(frame.t_s)
        if motion is None:
            return True
        started_s = self._clock.now_s()
        pose = VehiclePose(
            _triple(motion.state.position_ned_m),
            _triple(motion.state.velocity_ned_m_s),
            motion.roll_rad,
            motion.pitch_rad,
            motion.state.yaw_rad,
        )
        seen = self._pipeline.process(frame, pose, self.exclude)
        latency_s = self._clock.now_s() - started_s
        obstacles = ObstacleSet(frame.t_s, seen.discs, seen.unseen)
        self.newest = Perceived(obstacles, frame.t_s, frame.number, latency_s, self._source.health.skipped, seen.events)
        self._on_result()
        return True


def _triple(vector: Array) -> tuple[float, float, float]:
    return float(vector[0]), float(vector[1]), float(vector[2])

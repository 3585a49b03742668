"""What a camera would make known, on the virtual clock: the discs in range, at the camera's rate; and its faults.

No picture is rendered here: perception has its own tests and campaigns. What matters is that obstacles come, grow old, stop
coming, or that nothing is seen.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from flightapp.core.clock import Clock
from flightapp.core.types import Array, ObstacleSet
from flightapp.runtime.conditions import Notice
from flightapp.runtime.perception_thread import Perceived, PerceptionHealth
from flightapp.vehicle.pose_history import PoseHistory
from perception.sources import SourceHealth

CameraFault = Literal["", "off", "blind", "raises"]
WHOLE_CIRCLE = np.array([[-math.pi, math.pi]])
NOTHING_UNSEEN = np.zeros((0, 2))
LATENCY_S = 0.015


class VirtualCamera:
    """Stands where `PerceptionThread` does. `shoot` is called at the camera's rate."""

    def __init__(self, discs: Array, range_max_m: float, history: PoseHistory, clock: Clock) -> None:
        self._discs = discs
        self._range_max_m = range_max_m
        self._history = history
        self._clock = clock
        self._number = 0
        self.fault: CameraFault = ""
        self.newest: Perceived | None = None
        self.health = PerceptionHealth(SourceHealth())
        self.failure: str | None = None
        self.exclude: Array = np.zeros((0, 3))

    def shoot(self) -> bool:
        """Take a frame; True where there is a new result."""
        captured_s = self._clock.now_s() - LATENCY_S
        motion = self._history.at(captured_s)
        if self.fault == "off" or motion is None:
            return False
        if self.fault == "raises":
            self.failure = "RuntimeError: the camera is gone"
            return False
        self._number += 1
        north, east, _ = motion.state.position_ned_m.tolist()
        gap = np.hypot(self._discs[:, 0] - north, self._discs[:, 1] - east) - self._discs[:, 2]
        near = self._discs[gap < self._range_max_m]
        blind = self.fault == "blind"
        discs = near[:0] if blind else near
        obstacles = ObstacleSet(captured_s, discs, WHOLE_CIRCLE if blind else NOTHING_UNSEEN)
        ones = np.ones(len(discs))
        self.health = PerceptionHealth(SourceHealth(received=self._number), processed=self._number)
        self.newest = Perceived(obstacles, 0.0 * ones, ones, captured_s, self._number, LATENCY_S, LATENCY_S, self.health)
        return True

    def take_notices(self) -> list[Notice]:
        return []

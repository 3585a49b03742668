"""Pixels leave the driver's few buffers at once, into two of the source's own in turn."""

from __future__ import annotations

import numpy as np

from perception.sources.inbox import Arrival
from perception.sources.realsense_stream import intrinsics_of
from perception.types import DepthFrame


class FrameCopies:
    """Makes DepthFrames; the pixels of one stay until the second-next is made."""

    def __init__(self) -> None:
        self._buffers = [np.zeros((0, 0), np.uint16) for _ in range(2)]
        self.count = 0

    def take(self, arrival: Arrival, depth_unit_m: float) -> DepthFrame:
        pixels = np.asanyarray(arrival.frame.get_data())
        index = self.count % 2
        if self._buffers[index].shape != pixels.shape:
            self._buffers[index] = np.empty(pixels.shape, np.uint16)
        np.copyto(self._buffers[index], pixels)
        self.count += 1
        return DepthFrame(arrival.t_s, arrival.number, self._buffers[index], depth_unit_m, intrinsics_of(arrival.frame))

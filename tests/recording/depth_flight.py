"""A short flight whose depth frames are recorded by the real recorder."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from flightapp.config.profile import RecordingOptions
from flightapp.core.types import VehicleState
from flightapp.recording.depth import DepthCamera
from flightapp.recording.messages import CameraMounting
from flightapp.recording.recorder import Recorder
from flightapp.runtime.depth_recording import DepthRecording
from flightapp.vehicle.pose_history import PoseHistory
from perception.types import DepthFrame, Intrinsics
from tests.recording.samples import T0_S

LENS = Intrinsics(87, 49, 43.0, 44.0, 41.5, 23.25)
"""Sizes that no stride divides."""
CAMERA = DepthCamera(CameraMounting(0.12, -0.02, 0.03, 1.0, -10.0, 2.5), 0.3, 10.0, -1.5)
EVERY_FRAME = RecordingOptions(depth_rate_hz=90.0, chunk_bytes=4096)
"""In chunks smaller than a frame."""
RATE_HZ = 30.0


def frames(count: int, seed: int = 0) -> list[DepthFrame]:
    """Frames full of random depths, 30 a second."""
    random = np.random.default_rng(seed)
    shape = (LENS.height_px, LENS.width_px)
    return [
        DepthFrame(T0_S + k / RATE_HZ, 100 + k, random.integers(0, 65536, shape).astype(np.uint16), 0.00025, LENS)
        for k in range(count)
    ]


def history(duration_s: float = 1.0, start_s: float = T0_S - 0.1) -> PoseHistory:
    """Motion known at 50 Hz: north at 2 m/s, rolling and turning evenly."""
    known = PoseHistory()
    for t_s in np.arange(start_s, start_s + duration_s, 0.02):
        since_s = float(t_s) - T0_S
        known.append_state(VehicleState(float(t_s), np.array((2.0 * since_s, 1.0, -5.0)), np.array((2.0, 0.0, 0.0)), 0.0))
        known.append_attitude(float(t_s), 0.1 * since_s, -0.2, 0.5 * since_s)
    return known


def record(path: Path, shots: Iterable[DepthFrame], known: PoseHistory, options: RecordingOptions = EVERY_FRAME) -> Path:
    """All `shots`, one after the other, none dropped: each is on its way to the disk before the next one comes."""
    with Recorder(path, options=options) as recorder:
        recorder.metadata("run", {"vehicle": path.stem})
        for shot in shots:
            recording = DepthRecording(recorder, known, CAMERA, options)
            recording.offer(shot)
            recording.close()
    return path


def expected_north_m(t_s: float) -> float:
    return 2.0 * (t_s - T0_S)


def expected_yaw_rad(t_s: float) -> float:
    return math.remainder(0.5 * (t_s - T0_S), math.tau)

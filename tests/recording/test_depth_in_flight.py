"""A vehicle's camera, perception and recorder as they are put together for a flight, with depth in the recording."""

from __future__ import annotations

import threading
import time
from pathlib import Path

import numpy as np
import pytest

from flightapp.config.mission import load_mission
from flightapp.config.profile import load_profile
from flightapp.core.clock import SystemClock, monotonic_ns
from flightapp.core.types import VehicleState
from flightapp.recording.recorder import Recorder
from flightapp.runtime.composition import build_perception
from flightapp.vehicle.pose_history import PoseHistory
from perception.errors import PerceptionInputError
from perception.sources import SharedMemoryWriter
from perception.sources.mcap import McapSource
from perception.types import Intrinsics

ROOT = Path(__file__).resolve().parents[2]
MISSION = load_mission(ROOT / "missions" / "demo_two_pursuers.toml")
PROFILE = load_profile(ROOT / "profiles" / "sim.toml")
LENS = Intrinsics(160, 96, 80.0, 80.0, 80.0, 48.0)


def fly(tmp_path: Path, *, depth_rate_hz: float, frames: int) -> tuple[Path, list[np.ndarray]]:
    """The perception of p1 sees `frames` frames; returns the recording and what was shown."""
    clock, history, results = SystemClock(), PoseHistory(), threading.Semaphore(0)
    profile = PROFILE.model_copy(
        update={
            "camera": PROFILE.camera.model_copy(update={"path": tmp_path / "camera"}),
            "recording": PROFILE.recording.model_copy(update={"depth_rate_hz": depth_rate_hz, "depth_stride": 2}),
        }
    )
    writer = SharedMemoryWriter(tmp_path / "camera", LENS)
    shown = []
    with Recorder(tmp_path / "p1.mcap", options=profile.recording) as recorder:
        perception = build_perception(MISSION.vehicle("p1"), profile, clock, history, results.release, recorder)
        perception.start()
        for k in range(frames):
            shown.append(np.random.default_rng(k).integers(1000, 9000, (96, 160)).astype(np.uint16))
            _hear(history, clock.now_s())
            writer.write(shown[-1], monotonic_ns())
            _hear(history, clock.now_s())
            assert results.acquire(timeout=20.0)
        perception.stop()
    writer.close()
    return tmp_path / "p1.mcap", shown


def _hear(history: PoseHistory, t_s: float) -> None:
    history.append_state(VehicleState(t_s, np.array((1.0, 2.0, -5.0)), np.zeros(3), 0.25))
    history.append_attitude(t_s, 0.0, 0.0, 0.25)


def test_the_profile_switches_it_on(tmp_path: Path) -> None:
    path, shown = fly(tmp_path, depth_rate_hz=2.0, frames=1)
    source = McapSource(path)
    frame = source.latest()
    assert frame is not None
    np.testing.assert_array_equal(frame.depth, shown[0][::2, ::2])
    assert frame.intrinsics == Intrinsics(80, 48, 40.0, 40.0, 40.0, 24.0)
    assert frame.pose is not None
    assert frame.pose.position_ned_m == pytest.approx((1.0, 2.0, -5.0))
    assert frame.pose.yaw_rad == pytest.approx(0.25)
    assert time.time() - 60.0 < frame.t_s <= time.time()
    assert source.camera.mounting.forward_m == PROFILE.camera.mounting.forward_m
    assert source.camera.ground_down_m == -MISSION.vehicle("p1").start.ground_height_m


def test_it_is_off_unless_the_profile_says_otherwise(tmp_path: Path) -> None:
    path, _ = fly(tmp_path, depth_rate_hz=PROFILE.recording.depth_rate_hz, frames=1)
    with pytest.raises(PerceptionInputError, match="holds no depth frames"):
        McapSource(path)

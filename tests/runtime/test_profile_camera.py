"""The camera that the profile names is the one that perception gets, or one sentence says why not."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any, cast

import pytest

from flightapp.config.mission import load_mission
from flightapp.config.profile import load_profile
from flightapp.core.clock import SystemClock
from flightapp.core.errors import InputError
from flightapp.recording.recorder import Recorder
from flightapp.runtime.composition import build_perception
from flightapp.runtime.perception_thread import PerceptionThread
from flightapp.vehicle.pose_history import PoseHistory
from tests.perception.software_camera import SoftwareCamera, sdk

ROOT = Path(__file__).parents[2]


def perception_with(**camera: Any) -> PerceptionThread:
    """Perception of the demo's first vehicle with the D435 profile, its camera changed; nothing is recorded."""
    profile = load_profile(ROOT / "profiles" / "nuc-pixhawk6c-d435.toml")
    profile = profile.model_copy(update={"camera": profile.camera.model_copy(update=camera)})
    vehicle = load_mission(ROOT / "missions" / "demo_two_pursuers.toml").vehicles[0]
    nothing_recorded = cast(Recorder, None)
    return build_perception(vehicle, profile, SystemClock(), PoseHistory(), lambda: None, nothing_recorded)


def test_a_recording_stands_for_the_camera_on_the_bench(tmp_path: Path) -> None:
    SoftwareCamera().record(tmp_path / "camera.db3", [1, 2, 3])
    thread = perception_with(source="realsense-recording", path=tmp_path / "camera.db3")
    thread.start()
    deadline = time.monotonic() + 20
    while thread.health.source.received == 0 and time.monotonic() < deadline:
        time.sleep(0.01)
    thread.stop()
    assert thread.health.source.received > 0


def test_a_camera_that_is_not_there_is_named_with_the_field() -> None:
    sdk()
    with pytest.raises(InputError, match=r"^camera\.source = 'realsense': RealSense camera 000000000000 is not there"):
        perception_with(source="realsense", serial_number="000000000000")

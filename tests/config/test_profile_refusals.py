from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.config.tables import Change, profile_refusal

CASES: dict[str, tuple[tuple[str, ...], Any, list[str]]] = {
    "wrong unit": (("limits", "speed_max_km_h"), 18.0, ["limits.speed_max_km_h = 18.0", "did you mean 'speed_max_m_s'?"]),
    "zero speed": (("limits", "speed_max_m_s"), 0.0, ["limits.speed_max_m_s = 0.0", "must be greater than 0"]),
    "zero acceleration": (("limits", "acceleration_max_m_s2"), 0, ["limits.acceleration_max_m_s2 = 0", "greater than 0"]),
    "absurd speed": (("limits", "speed_max_m_s"), 300.0, ["limits.speed_max_m_s = 300.0", "must be at most 30"]),
    "text for a number": (("limits", "body_radius_m"), "0.4", ["limits.body_radius_m = '0.4'", "must be a number"]),
    "bad scheme": (("autopilot", "connection_url"), "udp://:14540", ["connection_url = 'udp://:14540'", "use udpin://HOST:PORT"]),
    "no host": (("autopilot", "connection_url"), "udpin://:1", ["connection_url = 'udpin://:1'", "udpin://0.0.0.0:14540"]),
    "no scheme": (("autopilot", "connection_url"), "/dev/ttyACM0", ["connection_url = '/dev/ttyACM0'", "serial:///dev/TTY:BAUD"]),
    "bad endpoint": (("network", "listen_endpoints"), ["udp:1"], ["network.listen_endpoints", "'udp:1'", "write udp/HOST:PORT"]),
    "camera range": (("camera", "range_max_m"), 0.1, ["camera.range_max_m = 0.1", "greater than range_min_m = 0.3"]),
    "unknown camera": (("camera", "source"), "webcam", ["camera.source = 'webcam'", "'shared-memory' or 'realsense'"]),
    "slow control loop": (("control", "rate_min_hz"), 5.0, ["control.rate_min_hz = 5.0", "must be at least 20"]),
    "slow deadman": (("control", "deadman_timeout_s"), 2.0, ["control.deadman_timeout_s = 2.0", "must be at most 0.45"]),
    "negative separation": (("safety", "separation_min_m"), -1.0, ["safety.separation_min_m = -1.0", "must be greater than 0"]),
    "unknown guard": (("safety", "separation_max_m"), 2.0, ["safety.separation_max_m = 2.0", "did you mean 'separation_min_m'?"]),
    "depth faster than cameras": (("recording", "depth_rate_hz"), 120, ["recording.depth_rate_hz = 120", "must be at most 90"]),
    "no depth pixel left": (("recording", "depth_stride"), 0, ["recording.depth_stride = 0", "must be at least 1"]),
    "infinite age": (("safety", "own_state_age_max_s"), float("inf"), ["safety.own_state_age_max_s = inf", "finite number"]),
}


@pytest.mark.parametrize(("path", "value", "wanted"), CASES.values(), ids=CASES.keys())
def test_the_sentence_names_file_field_value_and_what_would_be_right(
    path: tuple[str, ...], value: Any, wanted: list[str], tmp_path: Path
) -> None:
    change: Change = (path, value)
    sentence = profile_refusal(tmp_path, change)
    assert sentence.startswith("file.toml: ")
    assert "\n" not in sentence
    for part in wanted:
        assert part in sentence


def test_a_shared_memory_camera_needs_a_path(tmp_path: Path) -> None:
    sentence = profile_refusal(tmp_path, (("camera",), {"source": "shared-memory"}))
    assert sentence == "file.toml: camera.path: missing; source = 'shared-memory' needs it"


def test_a_recording_for_the_bench_needs_a_path(tmp_path: Path) -> None:
    sentence = profile_refusal(tmp_path, (("camera",), {"source": "realsense-recording"}))
    assert sentence == "file.toml: camera.path: missing; source = 'realsense-recording' needs it"


def test_a_realsense_has_few_rates(tmp_path: Path) -> None:
    sentence = profile_refusal(tmp_path, (("camera",), {"source": "realsense", "rate_hz": 75.0}))
    assert sentence == "file.toml: camera.rate_hz = 75: a RealSense offers 6, 15, 30, 60, 90"

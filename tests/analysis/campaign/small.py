"""A small scenario that is decided within three seconds of flight."""

from __future__ import annotations

from pathlib import Path

from flightapp.sim.batch.scenario import Scenario, load_scenario

TEXT = """
name = "small"
family = "dense"
time_limit_s = 4.0

[layout]
discs = 6
evader_start_m = [60.0, 25.0]
pursuer_starts_m = [[68.0, 18.0], [68.0, 32.0]]

[pursuers]
speed_max_m_s = 6.0

[evader]
policy = "straight"
speed_max_m_s = 3.0

[capture]
mode = "first"
"""


def small_file(folder: Path) -> Path:
    path = folder / "small.toml"
    path.write_text(TEXT)
    return path


def small_scenario(folder: Path) -> Scenario:
    return load_scenario(small_file(folder))

"""The demo mission: its strategies can be built as they stand in the file, and know what the mission says."""

from __future__ import annotations

from pathlib import Path

from flightapp.config.mission import load_mission
from flightapp.config.profile import load_profile
from flightapp.planning.encirclement.planner import EncirclementPlanner
from flightapp.runtime.composition import build_strategy

ROOT = Path(__file__).parents[3]
MISSION = ROOT / "missions/demo_encirclement.toml"


def test_four_pursuers_of_the_demo_encircle_within_its_flight_volume() -> None:
    mission, profile = load_mission(MISSION), load_profile(ROOT / "profiles/sim.toml")
    planners = [build_strategy(mission, one, profile, MISSION, 1) for one in mission.vehicles if one.role == "pursuer"]
    assert len(planners) == 4
    for planner in planners:
        assert isinstance(planner, EncirclementPlanner)
        parameters = planner._parameters
        assert parameters.capture.hold_radius_m == mission.capture.hold_radius_m
        assert parameters.flight_area_m is not None
        corners = mission.flight_volume.vertices_m
        assert min(n for n, _ in corners) < parameters.flight_area_m[0] < parameters.flight_area_m[2] < max(n for n, _ in corners)
        assert min(e for _, e in corners) < parameters.flight_area_m[1] < parameters.flight_area_m[3] < max(e for _, e in corners)

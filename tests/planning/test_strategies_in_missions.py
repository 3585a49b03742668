"""Every strategy of the registry flies in a mission that names it and says nothing else of it."""

from __future__ import annotations

from pathlib import Path

import pytest

from flightapp.config.mission import load_mission
from flightapp.config.profile import load_profile
from flightapp.core.errors import InputError
from flightapp.planning.adaptive_apf.planner import AdaptiveApfPlanner
from flightapp.planning.registry import planner_names
from flightapp.runtime.composition import build_strategy, build_team_plan

ROOT = Path(__file__).parents[2]
DEMO = ROOT / "missions/demo_two_pursuers.toml"
PROFILE = ROOT / "profiles/sim.toml"


def named(strategy: str, folder: Path) -> Path:
    path = folder / "mission.toml"
    path.write_text(DEMO.read_text().replace('strategy = { name = "ac2f" }', strategy))
    return path


@pytest.mark.parametrize("name", planner_names())
def test_one_line_in_a_mission_chooses_a_strategy(name: str, tmp_path: Path) -> None:
    path, profile = named(f'strategy = {{ name = "{name}" }}', tmp_path), load_profile(PROFILE)
    mission = load_mission(path)
    build_strategy(mission, mission.vehicles[0], profile, path, 0).reset()
    build_team_plan(mission, mission.vehicles[0], profile, path)


def test_a_strategy_captures_by_the_missions_rule(tmp_path: Path) -> None:
    path = named('strategy = { name = "adaptive-apf" }', tmp_path)
    mission = load_mission(path)
    planner = build_strategy(mission, mission.vehicles[0], load_profile(PROFILE), path, 0)
    assert isinstance(planner, AdaptiveApfPlanner)
    told = planner._parameters.capture
    assert (told.radius_m, told.mode, told.dwell_s) == (mission.capture.radius_m, mission.capture.mode, mission.capture.dwell_s)


def test_a_parameter_that_a_strategy_does_not_have_is_refused_by_its_name(tmp_path: Path) -> None:
    path = named('strategy = { name = "adaptive-apf", parameters = { goal_pover = 3.0 } }', tmp_path)
    mission = load_mission(path)
    with pytest.raises(InputError, match=r"p1.*adaptive-apf.*goal_pover is not a parameter"):
        build_strategy(mission, mission.vehicles[0], load_profile(PROFILE), path, 0)

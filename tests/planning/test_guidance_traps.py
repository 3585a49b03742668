"""Traps in the fast simulator: left with guidance, in less than twice the time of the shortest way; not left without."""

from __future__ import annotations

from pathlib import Path

import pytest

from flightapp.core.types import Decision, Observation
from flightapp.sim.batch.episode import Truth, fly
from flightapp.sim.batch.scenario import Scenario, load_scenario

TRAP = Path(__file__).parents[2] / "missions" / "scenarios" / "a1-u-trap.toml"
CAMERA = {
    "sensing.field_of_view_deg": "87.0",
    "sensing.range_m": "10.0",
    "sensing.latency_s": "0.06",
    "sensing.position_noise_m": "0.05",
    "sensing.radius_noise_m": "0.03",
    "sensing.occlusion": "true",
    "planner.parameters.reaction_s": "0.16",
}


def trap(depth_m: float, width_m: float, **more: str) -> Scenario:
    return load_scenario(TRAP, {"layout.depth_m": str(depth_m), "layout.width_m": str(width_m), **more})


class Told:
    """What the pursuer tells about its guidance, step by step."""

    def __init__(self) -> None:
        self.guided: list[bool] = []

    def step(self, t_s: float, observations: list[Observation], decisions: list[Decision], truth: Truth) -> None:
        self.guided.append(decisions[0].diagnostics["guidance"] == "guided around a trap")

    def end(self, truth: Truth) -> None: ...


@pytest.mark.parametrize("width_m", [4.0, 10.0, 16.0])
@pytest.mark.parametrize("depth_m", [2.0, 5.0, 12.0, 20.0])
def test_every_trap_is_left_in_less_than_twice_the_shortest_time(depth_m: float, width_m: float) -> None:
    scenario = trap(depth_m, width_m)
    told = Told()
    result = fly(scenario, "ac2f", 20001, watcher=told)
    assert result.outcome == "captured"
    assert result.capture_time_s is not None
    assert result.shortest_path_m is not None
    assert result.capture_time_s < 2.0 * result.shortest_path_m / scenario.pursuers.speed_max_m_s
    assert told.guided[1]  # it sees that it is in a trap before it flies into the wall
    assert not told.guided[-1]


@pytest.mark.parametrize(("depth_m", "width_m"), [(4.0, 6.0), (20.0, 16.0)])
def test_a_trap_is_left_with_a_camera_that_forgets_what_leaves_its_view(depth_m: float, width_m: float) -> None:
    assert fly(trap(depth_m, width_m, **CAMERA), "ac2f", 20002).outcome == "captured"


@pytest.mark.parametrize(("depth_m", "width_m"), [(16.0, 10.0), (20.0, 16.0)])
def test_without_guidance_the_trap_holds(depth_m: float, width_m: float) -> None:
    assert fly(trap(depth_m, width_m), "ac2f", 20001, {"guidance": False}).outcome == "timed_out"

"""What a strategy is made with: facts of vehicles, rules and layout that it knows how to use, and what a person chose."""

from __future__ import annotations

from collections.abc import Mapping

from flightapp.planning.registry import known_parameters
from flightapp.sim.batch.families.layout import Layout
from flightapp.sim.batch.scenario import Scenario

FACTS = frozenset(
    {
        "control_period_s",
        "evader_speed_assumed_m_s",
        "evader_radius_m",
        "capture",
        "vehicle",
        "polygons_m",
        "flight_area_m",
        "reaction_s",
        "response_lag_s",
        "command_blend",
        "vehicle_radius_max_m",
    }
)
"""Parameters that a scenario states for every planner; one that has no such parameter does without. Others must be known."""
UNDECLARED = FACTS - {"evader_radius_m", "vehicle", "polygons_m", "flight_area_m"}
"""What a planner is told that does not declare its parameters."""


def planner_parameters(
    scenario: Scenario, planner: str, parameters: Mapping[str, object] | None = None, layout: Layout | None = None
) -> dict[str, object]:
    """Of a pursuer: the scenario's facts, its [planner.parameters], those of [planner.own] for `planner`, then `parameters`."""
    told: dict[str, object] = {
        "control_period_s": scenario.control_period_s,
        "evader_speed_assumed_m_s": scenario.evader.speed_max_m_s,
        "evader_radius_m": scenario.evader.body_radius_m,
        "capture": scenario.capture.model_dump(),
        "vehicle": scenario.pursuers.model,
        **_polygons(layout),
        **scenario.planner.parameters,
    }
    known = known_parameters(planner)
    wanted = UNDECLARED if known is None else known
    facts = {name: value for name, value in told.items() if name in wanted or name not in FACTS}
    return {**facts, **scenario.planner.own.get(planner, {}), **(parameters or {})}


def evader_parameters(scenario: Scenario, known: frozenset[str], layout: Layout) -> dict[str, object]:
    """Of the evader's policy: its own in the scenario, and the layout's polygons where `known` has them."""
    polygons = _polygons(layout) if "polygons_m" in known else {}
    return {**polygons, **scenario.evader.parameters}


def _polygons(layout: Layout | None) -> dict[str, object]:
    if layout is None or not layout.polygons:
        return {}
    return {"polygons_m": [polygon.tolist() for polygon in layout.polygons]}

"""Strategies by name. A new one is a folder and one line here.

Each is a module with `build(name, limits, given, seed)`, imported when it is first asked for: a vehicle loads no strategy but
its own, with the parts that it shares with others.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import cast

from flightapp.core.errors import InputError
from flightapp.core.types import Limits
from flightapp.fleet.coordination.team_plan import TeamPlan
from flightapp.planning.ac2f.variants import VARIANTS, left_open
from flightapp.planning.api import Build, BuildTeamPlan, Given, Planner

ADAPTIVE_APF = ("adaptive-apf", "conventional-apf", "iapf-style")
ENCIRCLEMENT = ("oa-ecbvc", "oavc", "surround-hunt", "spaced", "greedy")

PLANNERS: Mapping[str, str] = {
    **dict.fromkeys(VARIANTS, "flightapp.planning.ac2f.build"),
    **dict.fromkeys(("hunting", "tracking-hunting", "dwa"), "flightapp.planning.hunting.build"),
    **dict.fromkeys(ENCIRCLEMENT, "flightapp.planning.encirclement.build"),
    **dict.fromkeys(ADAPTIVE_APF, "flightapp.planning.adaptive_apf.build"),
}

TEAM_PLANS: Mapping[str, str] = {
    "hunting": "flightapp.planning.hunting.team_plan",
}
"""Strategies whose leader plans otherwise than by sectors around the evader."""

UNLED = frozenset((*ENCIRCLEMENT, "tracking-hunting", "dwa"))
"""Strategies that take no notice of a plan by sectors: where nobody looks on, none is made for them."""

EVADERS: Mapping[str, str] = {
    "adversarial": "flightapp.planning.evasion.adversarial",
    "boundary-seeking": "flightapp.planning.evasion.boundary_seeking",
    "climb-and-dive": "flightapp.planning.evasion.climb_and_dive",
    "flee-nearest": "flightapp.planning.evasion.flee_nearest",
    "gap-runner": "flightapp.planning.evasion.gap_runner",
    "goal-seeker": "flightapp.planning.evasion.goal_seeker",
    "hover": "flightapp.planning.evasion.hover",
    "inverse-square": "flightapp.planning.evasion.inverse_square",
    "manoeuvring": "flightapp.planning.evasion.manoeuvring",
    "random-waypoints": "flightapp.planning.evasion.random_waypoints",
    "recorded": "flightapp.planning.evasion.recorded",
    "straight": "flightapp.planning.evasion.straight",
    "voronoi-centroid": "flightapp.planning.evasion.voronoi_centroid",
    "waypoints": "flightapp.planning.evasion.waypoints",
}


def make_planner(name: str, *, limits: Limits, parameters: Given = None, seed: int = 0) -> Planner:
    """The pursuit strategy `name`; InputError on an unknown name or bad parameters."""
    if name not in PLANNERS:
        raise InputError(f"strategy.name = '{name}': no such pursuer strategy; known: {', '.join(planner_names())}")
    return _built(PLANNERS[name], name, limits, parameters, seed)


def make_team_plan(name: str, *, limits: Limits, parameters: Given = None) -> TeamPlan | None:
    """What the leader of a team under the strategy `name` plans by; None: by sectors around the evader."""
    if name not in TEAM_PLANS:
        return None
    build = cast(BuildTeamPlan, importlib.import_module(TEAM_PLANS[name]).build_team_plan)
    return build(name, limits, parameters)


def make_evader(name: str, *, limits: Limits, parameters: Given = None, seed: int = 0) -> Planner:
    """The evader policy `name`; InputError on an unknown name or bad parameters."""
    if name not in EVADERS:
        raise InputError(f"strategy.name = '{name}': no such evader policy; known: {', '.join(evader_names())}")
    return _built(EVADERS[name], name, limits, parameters, seed)


def _built(module: str, name: str, limits: Limits, given: Given, seed: int) -> Planner:
    build = cast(Build, importlib.import_module(module).build)
    return build(name, limits, given, seed)


def known_parameters(name: str) -> frozenset[str] | None:
    """The parameters that a strategy or policy has; None where its module does not declare them as PARAMETERS."""
    module = PLANNERS.get(name) or EVADERS.get(name)
    model = None if module is None else getattr(importlib.import_module(module), "PARAMETERS", None)
    return None if model is None else frozenset(model.model_fields)


def file_parameters(name: str, values: Mapping[str, object]) -> dict[str, object]:
    """The values of a parameter file for the pursuit strategy `name`, without those that the strategy itself fixes."""
    return left_open(name, values) if name in VARIANTS else dict(values)


def planner_names() -> tuple[str, ...]:
    """Names of the pursuit strategies."""
    return tuple(sorted(PLANNERS))


def evader_names() -> tuple[str, ...]:
    """Names of the evader policies."""
    return tuple(sorted(EVADERS))

"""Path planners by name; each module is imported when it is first asked for."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from typing import cast

from flightapp.core.errors import InputError
from flightapp.planning.path_planning.api import Given, PathPlanner

OMPL = "flightapp.planning.path_planning.ompl_planner"
PATH_PLANNERS: Mapping[str, str] = {
    "rrt-star-apf": "flightapp.planning.path_planning.rrt_star.planner",
    "rrt-star-apf-paper": "flightapp.planning.path_planning.rrt_star.planner",
    "rrt-star": "flightapp.planning.path_planning.rrt_star.planner",
    "ompl-aorrtc": OMPL,
    "ompl-bit-star": OMPL,
    "ompl-informed-rrt-star": OMPL,
    "ompl-rrt-connect": OMPL,
    "ompl-rrt-star": OMPL,
}


def make_path_planner(name: str, parameters: Given = None) -> PathPlanner:
    """The path planner `name`; InputError on an unknown name, bad parameters, or a package that is not installed."""
    if name not in PATH_PLANNERS:
        raise InputError(f"planner = '{name}': no such path planner; known: {', '.join(sorted(PATH_PLANNERS))}")
    build = cast(Callable[[str, Given], PathPlanner], importlib.import_module(PATH_PLANNERS[name]).build)
    return build(name, parameters)

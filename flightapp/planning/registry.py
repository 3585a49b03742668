"""Strategies by name. A new one is a folder and one line here."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from flightapp.core.errors import InputError
from flightapp.core.types import Limits
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.planner import Ac2fPlanner
from flightapp.planning.ac2f.variants import VARIANTS, left_open, with_variant
from flightapp.planning.api import Planner
from flightapp.planning.evasion.adversarial import Adversarial
from flightapp.planning.evasion.boundary_seeking import BoundarySeeking
from flightapp.planning.evasion.hover import Hover
from flightapp.planning.evasion.parameters import (
    AdversarialParameters,
    BoundarySeekingParameters,
    HoverParameters,
    RecordedParameters,
    StraightParameters,
    VoronoiCentroidParameters,
    WaypointsParameters,
)
from flightapp.planning.evasion.recorded import Recorded
from flightapp.planning.evasion.straight import Straight
from flightapp.planning.evasion.voronoi_centroid import VoronoiCentroid
from flightapp.planning.evasion.waypoints import Waypoints
from flightapp.planning.parameters import parsed

Given = Mapping[str, object] | None
Builder = Callable[[Limits, Given, int], Planner]


def _ac2f(name: str) -> Builder:
    def build(limits: Limits, given: Given, _seed: int) -> Planner:
        return Ac2fPlanner(limits=limits, parameters=parsed(Ac2fParameters, name, with_variant(name, given)))

    return build


def _adversarial(limits: Limits, given: Given, _seed: int) -> Planner:
    return Adversarial(limits=limits, parameters=parsed(AdversarialParameters, "adversarial", given))


def _boundary_seeking(limits: Limits, given: Given, _seed: int) -> Planner:
    return BoundarySeeking(limits=limits, parameters=parsed(BoundarySeekingParameters, "boundary-seeking", given))


def _hover(limits: Limits, given: Given, _seed: int) -> Planner:
    parsed(HoverParameters, "hover", given)
    return Hover(limits=limits)


def _recorded(limits: Limits, given: Given, _seed: int) -> Planner:
    return Recorded(limits=limits, parameters=parsed(RecordedParameters, "recorded", given))


def _straight(limits: Limits, given: Given, seed: int) -> Planner:
    return Straight(limits=limits, parameters=parsed(StraightParameters, "straight", given), seed=seed)


def _voronoi_centroid(limits: Limits, given: Given, _seed: int) -> Planner:
    return VoronoiCentroid(limits=limits, parameters=parsed(VoronoiCentroidParameters, "voronoi-centroid", given))


def _waypoints(limits: Limits, given: Given, _seed: int) -> Planner:
    return Waypoints(limits=limits, parameters=parsed(WaypointsParameters, "waypoints", given))


PLANNERS: Mapping[str, Builder] = {name: _ac2f(name) for name in VARIANTS}

EVADERS: Mapping[str, Builder] = {
    "adversarial": _adversarial,
    "boundary-seeking": _boundary_seeking,
    "hover": _hover,
    "recorded": _recorded,
    "straight": _straight,
    "voronoi-centroid": _voronoi_centroid,
    "waypoints": _waypoints,
}


def make_planner(name: str, *, limits: Limits, parameters: Given = None, seed: int = 0) -> Planner:
    """The pursuit strategy `name`; InputError on an unknown name or bad parameters."""
    if name not in PLANNERS:
        raise InputError(f"strategy.name = '{name}': no such pursuer strategy; known: {', '.join(planner_names())}")
    return PLANNERS[name](limits, parameters, seed)


def make_evader(name: str, *, limits: Limits, parameters: Given = None, seed: int = 0) -> Planner:
    """The evader policy `name`; InputError on an unknown name or bad parameters."""
    if name not in EVADERS:
        raise InputError(f"strategy.name = '{name}': no such evader policy; known: {', '.join(evader_names())}")
    return EVADERS[name](limits, parameters, seed)


def file_parameters(name: str, values: Mapping[str, object]) -> dict[str, object]:
    """The values of a parameter file for the pursuit strategy `name`, without those that the strategy itself fixes."""
    return left_open(name, values) if name in VARIANTS else dict(values)


def planner_names() -> tuple[str, ...]:
    """Names of the pursuit strategies."""
    return tuple(sorted(PLANNERS))


def evader_names() -> tuple[str, ...]:
    """Names of the evader policies."""
    return tuple(sorted(EVADERS))

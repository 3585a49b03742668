"""The encirclement strategies, as the registry asks for them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from flightapp.core.errors import InputError
from flightapp.core.types import Limits
from flightapp.planning.api import Given, Planner
from flightapp.planning.encirclement.methods.bounded_voronoi import cell_centroid
from flightapp.planning.encirclement.methods.greedy import nearest_to_evader
from flightapp.planning.encirclement.methods.information import InformationCentroid
from flightapp.planning.encirclement.methods.spaced import Spaced
from flightapp.planning.encirclement.methods.surround import SurroundHunt
from flightapp.planning.encirclement.moment import Method
from flightapp.planning.encirclement.parameters import EncirclementParameters
from flightapp.planning.encirclement.planner import EncirclementPlanner
from flightapp.planning.parameters import parsed

PARAMETERS = EncirclementParameters
MakeMethod = Callable[[EncirclementParameters, Limits], Method]

METHODS: Mapping[str, MakeMethod] = {
    "oa-ecbvc": lambda _parameters, _limits: cell_centroid,
    "oavc": lambda parameters, _limits: InformationCentroid(parameters.information_sigma_m),
    "surround-hunt": lambda parameters, limits: SurroundHunt(
        parameters.surround_gain_1_s, parameters.surround_hunting_share, limits.speed_max_m_s
    ),
    "spaced": lambda parameters, limits: Spaced(_ring_m(parameters), limits.speed_max_m_s),
    "greedy": lambda _parameters, _limits: nearest_to_evader,
}


def _ring_m(parameters: EncirclementParameters) -> float:
    rule = parameters.capture
    return parameters.spaced_radius_share * rule.radius_m if rule.mode == "first" else rule.hold_radius_m


def build(name: str, limits: Limits, given: Given, _seed: int) -> Planner:
    """The method `name`; InputError on parameters that cannot be."""
    parameters = parsed(EncirclementParameters, name, given)
    if parameters.capture.radius_m <= limits.body_radius_m:
        raise InputError(
            f"strategy '{name}': capture.radius_m = {parameters.capture.radius_m}: must be greater than "
            f"{limits.body_radius_m:g}, the pursuer's own body"
        )
    return EncirclementPlanner(limits=limits, parameters=parameters, method=partial(METHODS[name], parameters, limits))

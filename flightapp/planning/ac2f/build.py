"""AC2F and its variants, as the registry asks for them."""

from __future__ import annotations

from flightapp.core.types import Limits
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.planner import Ac2fPlanner
from flightapp.planning.ac2f.variants import with_variant
from flightapp.planning.ac2f.volume.planner import VolumePlanner
from flightapp.planning.api import Given, Planner
from flightapp.planning.parameters import parsed

PARAMETERS = Ac2fParameters


def build(name: str, limits: Limits, given: Given, _seed: int) -> Planner:
    """The variant `name`; InputError on parameters that it does not have or that it fixes."""
    parameters = parsed(Ac2fParameters, name, with_variant(name, given))
    planar = Ac2fPlanner(limits=limits, parameters=parameters)
    return VolumePlanner(planar, limits, parameters) if parameters.volume.space == "volume" else planar

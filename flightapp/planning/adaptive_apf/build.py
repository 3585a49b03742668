"""The adaptive potential field and its baselines, as the registry asks for them. `apf` is another one: a variant of AC2F."""

from __future__ import annotations

from collections.abc import Mapping

from flightapp.core.errors import InputError
from flightapp.core.types import Limits
from flightapp.planning.adaptive_apf.parameters import AdaptiveApfParameters
from flightapp.planning.adaptive_apf.planner import AdaptiveApfPlanner
from flightapp.planning.api import Given, Planner
from flightapp.planning.parameters import parsed

PARAMETERS = AdaptiveApfParameters

VARIANTS: Mapping[str, Mapping[str, object]] = {
    "adaptive-apf": {},
    "conventional-apf": {"modules": ""},
    "iapf-style": {"modules": "A", "law": "double-integrator"},
}
"""What a name fixes. The steps of the ablation are `adaptive-apf` with `modules`."""


def build(name: str, limits: Limits, given: Given, seed: int) -> Planner:
    """The variant `name`; InputError on parameters that do not exist or that it fixes otherwise."""
    fixed = VARIANTS[name]
    for field, value in fixed.items():
        if given is not None and given.get(field, value) != value:
            raise InputError(f"strategy '{name}': {field} = {given[field]!r}: this strategy is the one with {value!r}")
    parameters = parsed(AdaptiveApfParameters, name, {**(given or {}), **fixed})
    return AdaptiveApfPlanner(limits=limits, parameters=parameters, seed=seed)

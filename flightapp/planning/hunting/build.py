"""Hunting and its baselines, as the registry asks for them."""

from __future__ import annotations

import math
from collections.abc import Mapping

from flightapp.core.errors import InputError
from flightapp.core.types import Limits
from flightapp.planning.api import Given, Planner
from flightapp.planning.hunting.parameters import HuntingParameters
from flightapp.planning.hunting.planner import HuntingPlanner
from flightapp.planning.parameters import parsed

PARAMETERS = HuntingParameters

VARIANTS: Mapping[str, Mapping[str, object]] = {
    "hunting": {},
    "tracking-hunting": {"goal": "target"},
    "dwa": {"goal": "target", "window": "cycle", "guidance": False, "right_hand": False},
}
"""What a name fixes: tracking keeps the local planner, plain DWA has neither window nor guidance nor rule of the paper."""


def parameters_of(name: str, given: Given) -> HuntingParameters:
    """`given` with what the variant `name` fixes; InputError on parameters that do not exist or that it fixes otherwise."""
    fixed = VARIANTS[name]
    for field, value in fixed.items():
        if given is not None and given.get(field, value) != value:
            raise InputError(f"strategy '{name}': {field} = {given[field]!r}: this strategy is the one with {value!r}")
    return parsed(HuntingParameters, name, {**(given or {}), **fixed})


MOVING = ("speed_max_m_s", "acceleration_max_m_s2", "yaw_rate_max_rad_s", "yaw_acceleration_max_rad_s2", "body_radius_m")


def build(name: str, limits: Limits, given: Given, seed: int) -> Planner:
    """The variant `name`; InputError where a vehicle with `limits` could not move or turn."""
    for field in MOVING:
        value = getattr(limits, field)
        if not (math.isfinite(value) and value > 0.0):
            raise InputError(f"strategy '{name}': limits.{field} = {value}: must be a finite number greater than 0")
    return HuntingPlanner(limits=limits, parameters=parameters_of(name, given), seed=seed)

"""Named variants of AC2F: each fixes some parameters, whatever a parameter file says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from flightapp.core.errors import InputError

Values = Mapping[str, object]


@dataclass(frozen=True, slots=True)
class Variant:
    """`fixed` values cannot be changed; `preset` ones are only other defaults."""

    fixed: Values = field(default_factory=dict)
    preset: Values = field(default_factory=dict)


PLAIN_FIELD: Values = {"lead": False, "avoidance": "field", "guidance": False}
"""The source's coarse stage: no lead, a plain potential field, no way around traps."""

VARIANTS: Mapping[str, Variant] = {
    "ac2f": Variant(),
    "ac2f-literal": Variant(
        {**PLAIN_FIELD, "aim": "goal", "raw_scores": True, "no_admissible": "brake"}, {"admissibility": False}
    ),
    "ac2f-no-memory": Variant({"memory_weight": 0.0, "guidance": False}),
    "ac2f-no-terminal": Variant({"terminal_adaptation": False}),
    "apf": Variant({**PLAIN_FIELD, "stages": "coarse", "goal": "evader"}),
    "dwa-fixed": Variant(
        {
            "stages": "fine",
            "no_admissible": "brake",
            "goal": "evader",
            "lead": False,
            "memory_weight": 0.0,
            "terminal_adaptation": False,
            "guidance": False,
        }
    ),
    "geo-apf": Variant({**PLAIN_FIELD, "stages": "coarse"}),
}


def with_variant(name: str, given: Values | None) -> dict[str, object]:
    """The parameters of the strategy `name` where a person gave `given`; InputError where they contradict the variant."""
    variant = VARIANTS[name]
    for key, value in variant.fixed.items():
        if given is not None and key in given and given[key] != value:
            raise InputError(f"strategy '{name}': {key} = {given[key]!r}: this variant fixes it to {value!r}; leave it out")
    return {**variant.preset, **(given or {}), **variant.fixed}


def left_open(name: str, values: Values) -> dict[str, object]:
    """`values` of a parameter file, which serves all variants, without those that the strategy `name` fixes."""
    return {key: value for key, value in values.items() if key not in VARIANTS[name].fixed}

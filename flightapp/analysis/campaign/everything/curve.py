"""What of the grid is drawn against a quantity that its scenarios differ in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from pydantic import Field

from flightapp.config.loading import Strict
from flightapp.core.errors import InputError
from flightapp.sim.batch.scenario import Scenario


class Curve(Strict):
    """Some of the table's scenarios, drawn against one number in them."""

    name: str = Field(pattern=r"^[a-z0-9-]+$")
    """Of the files: NAME-success.png and NAME-distances.png."""
    title: str = Field(min_length=1)
    scenarios: tuple[str, ...] = Field(min_length=2)
    """Their names."""
    against: str
    """The number: `table.field` of a scenario file."""
    label: str
    """What it is, with its unit."""


def checked(curves: Sequence[Curve], scenarios: Mapping[str, Scenario], path: Path) -> tuple[Curve, ...]:
    """`curves`; InputError where one names what the file `path` does not have."""
    for curve in curves:
        for name in curve.scenarios:
            if name not in scenarios:
                raise InputError(f"{path}: curves: {curve.name}: no scenario '{name}' in families; it has {', '.join(scenarios)}")
            number_of(scenarios[name], curve, path)
    return tuple(curves)


def number_of(scenario: Scenario, curve: Curve, path: Path | None = None) -> float:
    """The quantity in `scenario`; InputError where it has no such number."""
    value: object = scenario.model_dump()
    for part in curve.against.split("."):
        value = value.get(part) if isinstance(value, dict) else None
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{path}: curves: {curve.name}: against = '{curve.against}': no number in scenario '{scenario.name}'")
    return float(value)

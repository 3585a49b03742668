"""Where vehicles start: at given places, along a line, or drawn in a box."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from pydantic import Field, model_validator

from flightapp.config.loading import Strict
from flightapp.core.errors import InputError
from flightapp.core.types import Array
from flightapp.sim.batch.families.layout import Start

Place = tuple[float, float]
Box = tuple[float, float, float, float]
ATTEMPTS_MAX = 10_000


class Starts(Strict):
    """Exactly one of `at_m`, `line_m` and `box_m`; places are north, east in m."""

    at_m: tuple[Place, ...] = ()
    """One place a vehicle."""
    line_m: Box | None = None
    """North, east of the first, north, east of the last; the others evenly between."""
    box_m: Box | None = None
    """Least north, least east, greatest north, greatest east: drawn evenly."""
    apart_m: float = Field(default=0.0, ge=0)
    """Drawn vehicles start at least so far from one another and from those that start before."""
    noise_m: float = Field(default=0.0, ge=0)
    """Given places are shaken by up to this, each axis."""
    heading_rad: tuple[float, ...] = ()
    """Clockwise from north, one a vehicle; empty: pursuers towards the evader, the evader to its goal or away."""

    @model_validator(mode="after")
    def _is_one_kind(self) -> Starts:
        kinds = (bool(self.at_m), self.line_m is not None, self.box_m is not None)
        if sum(kinds) != 1:
            raise ValueError("give exactly one of at_m, line_m and box_m")
        if self.box_m is not None and (self.box_m[0] > self.box_m[2] or self.box_m[1] > self.box_m[3]):
            raise ValueError(f"box_m = {list(self.box_m)}: must be least north, least east, greatest north, greatest east")
        return self

    def places(self, count: int, field: str, others: Sequence[Place], random: np.random.Generator) -> list[Place]:
        """Of `count` vehicles; `field` is the table's name for an InputError where they do not fit, `others` start already."""
        if self.heading_rad and len(self.heading_rad) != count:
            raise InputError(f"layout.{field}.heading_rad: {len(self.heading_rad)} headings for {count} vehicles; give one each")
        if self.box_m is not None:
            return self._drawn(count, field, others, random)
        if self.line_m is not None:
            ends = np.array(self.line_m).reshape(2, 2)
            share = np.linspace(0.0, 1.0, count) if count > 1 else np.array([0.5])
            given = ends[0] + share[:, np.newaxis] * (ends[1] - ends[0])
        else:
            if len(self.at_m) < count:
                raise InputError(f"layout.{field}.at_m: {len(self.at_m)} places for {count} vehicles; give one each")
            given = np.array(self.at_m[:count])
        shaken: Array = given + self.noise_m * random.uniform(-1.0, 1.0, given.shape)
        return [(north, east) for north, east in shaken.tolist()]

    def _drawn(self, count: int, field: str, others: Sequence[Place], random: np.random.Generator) -> list[Place]:
        assert self.box_m is not None
        low, high = self.box_m[:2], self.box_m[2:]
        found: list[Place] = []
        for _ in range(ATTEMPTS_MAX):
            if len(found) == count:
                break
            north, east = random.uniform(low, high).tolist()
            if all(math.dist((north, east), other) >= self.apart_m for other in (*others, *found)):
                found.append((north, east))
        if len(found) < count:
            raise InputError(
                f"layout.{field}.apart_m = {self.apart_m}: only {len(found)} of {count} vehicles found room; a larger box_m"
            )
        return found

    def headed(self, places: Sequence[Place], towards: Place) -> tuple[Start, ...]:
        """Starts at `places`; those without a heading head for `towards`."""
        bearings = [math.atan2(towards[1] - east, towards[0] - north) for north, east in places]
        headings = self.heading_rad or bearings
        return tuple(Start(n, e, heading) for (n, e), heading in zip(places, headings, strict=True))


def middle(places: Sequence[Place]) -> Place:
    """The mean of `places`."""
    return sum(n for n, _ in places) / len(places), sum(e for _, e in places) / len(places)

"""Obstacles and volumes not to be flown through that are known before the flight, in three dimensions."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from flightapp.config.loading import Strict

Place = Annotated[float, Field(ge=-20_000, le=20_000)]
Size = Annotated[float, Field(gt=0, le=10_000)]


class _Upright(Strict):
    """Between two heights above the datum; without a height it has no end there."""

    north_m: Place
    east_m: Place
    bottom_m: float | None = None
    top_m: float | None = None

    @model_validator(mode="after")
    def _is_upright(self) -> _Upright:
        if self.bottom_m is not None and self.top_m is not None and self.top_m <= self.bottom_m:
            raise ValueError(f"top_m = {self.top_m}: must be greater than bottom_m = {self.bottom_m}")
        return self


class KnownCylinder(_Upright):
    shape: Literal["cylinder"]
    radius_m: Size


class KnownBox(_Upright):
    """`length_m` along `heading_deg`, `width_m` across."""

    shape: Literal["box"]
    length_m: Size
    width_m: Size
    heading_deg: float = 0.0


class KnownSphere(Strict):
    shape: Literal["sphere"]
    north_m: Place
    east_m: Place
    height_m: float
    """Of its centre above the datum."""
    radius_m: Size


KnownObstacle = Annotated[KnownCylinder | KnownBox | KnownSphere, Field(discriminator="shape")]


def distance_to_column_m(known: KnownObstacle, north_m: float, east_m: float, bottom_m: float, top_m: float) -> float:
    """From `known` to the upright line at a place (mission frame) between two heights above the datum; 0 inside."""
    north, east = north_m - known.north_m, east_m - known.east_m
    if isinstance(known, KnownSphere):
        up = max(bottom_m - known.height_m, known.height_m - top_m, 0.0)
        return max(0.0, math.hypot(north, east, up) - known.radius_m)
    if isinstance(known, KnownBox):
        heading = math.radians(known.heading_deg)
        along = abs(north * math.cos(heading) + east * math.sin(heading)) - known.length_m / 2
        across = abs(-north * math.sin(heading) + east * math.cos(heading)) - known.width_m / 2
        planar = math.hypot(max(along, 0.0), max(across, 0.0))
    else:
        planar = max(0.0, math.hypot(north, east) - known.radius_m)
    above = -math.inf if known.top_m is None else bottom_m - known.top_m
    below = -math.inf if known.bottom_m is None else known.bottom_m - top_m
    return math.hypot(planar, max(above, below, 0.0))

"""Every number of the vertical part of AC2F, with its unit."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from flightapp.planning.parameters import StrategyParameters


class VolumeParameters(StrategyParameters):
    """Heights are metres above the datum, height = -down. The climb and sink rate limits come with the vehicle's limits."""

    space: Literal["plane", "volume"] = "plane"
    """`plane`: the source's planar pursuit at the mission's height; `volume`: up and down to the evader as well."""
    height_min_m: float = Field(default=2.0, ge=0)
    """The vehicle does not go below by itself."""
    height_max_m: float = Field(default=30.0, gt=0)
    """Nor above."""
    acceleration_max_m_s2: float = Field(default=2.0, gt=0)
    """Of climb and sink: how fast the vertical velocity is changed, and what vertical braking may assume."""
    reaction_s: float = Field(default=0.4, ge=0)
    """Time from a decision until the vertical velocity answers to it."""
    gain_1_s: float = Field(default=1.5, gt=0)
    """Vertical speed towards the evader's height per metre, where braking does not ask for less."""
    obstacle_margin_m: float = Field(default=1.0, gt=0)
    """Kept above an obstacle's top and below its underside, from the own centre: body and what a height is known to. In a mission
    more than the supervisor's body radius and `obstacle_height_margin_m`, or that stops the vehicle before what it would pass.
    """
    memory_s: float = Field(default=10.0, ge=0)
    """How long an obstacle of known height that is no longer seen is still kept away from."""

    @model_validator(mode="after")
    def _is_band(self) -> VolumeParameters:
        if self.height_min_m >= self.height_max_m:
            raise ValueError(f"height_min_m = {self.height_min_m} must be less than height_max_m = {self.height_max_m}")
        return self

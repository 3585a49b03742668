"""Parameters of RRT*-APF and of RRT*; the values of the paper as a preset."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from flightapp.planning.parameters import StrategyParameters

PAPER: dict[str, object] = {"step_m": 2.0, "informed": False, "radius_max_m": 6.0}


class RrtStarParameters(StrategyParameters):
    """Section 2.3 of the specification; names of the paper in brackets."""

    preset: Literal["default", "paper"] = "default"
    """`paper`: its step of 2 m and samples from everywhere, unless stated otherwise here."""
    step_m: float = Field(default=10.0, gt=0.1, le=100)
    """[s_t] Longest edge."""
    goal_share: float = Field(default=0.05, ge=0, lt=1)
    """[p_g]"""
    radius_max_m: float | None = Field(default=None, gt=0)
    """Within which a node looks for parents and children, at most; None: 1.5 steps, at least 6 m. The paper gives none."""
    radius_factor: float = Field(default=1.1, ge=1, le=10)
    informed: bool = True
    """Once there is a way, sample only where a shorter one can lead."""
    push_share: float = Field(default=0.3, ge=0)
    """[alpha] Of the potential field's force, by which a sample is moved; 0: it stays. Informed samples stay: the shortest way
    passes close to bodies, and the push would keep the tree from there."""
    push_gain: float = Field(default=1.5, ge=0)
    """[eta]"""
    push_reach_m: float = Field(default=8.0, gt=0, le=10)
    """[d_0]"""
    predictive: bool = True
    """Edges that a moving body will meet are refused."""

"""The numbers that the kernels of the field read."""

from __future__ import annotations

from typing import NamedTuple

import numba

from flightapp.space.bodies import NUMBER


class Gains(NamedTuple):
    """SI units; switches are 0.0 or 1.0. Modules A to D are those of the source's ablation."""

    attraction_1_s2: float
    attraction_reach_m: float
    """Farther from the goal than this, attraction does not grow."""
    repulsion: float
    """m^4/s^2; with the literal goal factor m^(4-n)/s^2."""
    gap_min_m: float
    """Nearer than this, repulsion does not grow."""
    force_max_m_s2: float
    """Of one body."""
    goal_aware: float
    """Module A: repulsion vanishes at the goal."""
    goal_power: float
    """n, at least 2: with less the force does not vanish at the goal (n = 1) or is infinite there."""
    goal_bounded: float
    """1: the factor tends to 1 far from the goal; 0: it is the n-th power of the distance, as printed."""
    goal_scale_min_m: float
    predictive: float
    """Module C: steering, braking and return."""
    kinematic: float
    """1: the vehicle turns at once, so what a manoeuvre demands is speed and not acceleration."""
    steering_m_s2: float
    """Full authority of steering."""
    braking_m_s2: float
    speed_m_s: float
    """Nominal."""
    horizon_s: float
    delay_s: float
    body_radius_m: float
    margin_m: float
    vertical_weight: float
    """Of steering: 0 stays in the plane, 1 is free."""
    return_1_s2: float
    """0: no return to the line from start to goal."""
    return_max_m_s2: float
    return_zones: float
    """1: the source's three zones in the place of a damped pull, not limited."""
    adaptive: float
    """Module D: activation distance and speed follow the threat."""
    printed: float
    """1: activation distance and fuzzy table as printed."""
    reach_m: float
    """Activation distance without module D."""
    reach_min_m: float
    reach_max_m: float
    obstacle_s: float
    """Printed form: metres of activation distance for each m/s of the obstacle."""
    only_closing: float
    """1: only bodies that come nearer repel (IAPF-style)."""


GAINS = numba.types.NamedUniTuple(NUMBER, len(Gains._fields), Gains)  # type: ignore[no-untyped-call]

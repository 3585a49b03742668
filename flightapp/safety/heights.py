"""Known obstacles of known height: which of them a vehicle passes above or below, and the climb and sink rates that keep it so.

A height is known where `down_top_m` or `down_bottom_m` is finite; an obstacle without either reaches over all heights. At any
time one of two things holds for each obstacle: the vehicle can still end its vertical motion clear of it (it is passed, and the
rates are bounded while it is near), or it stands in the way and the planar guard can still stop before it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightapp.core.clearance import disc_clearances_m
from flightapp.core.types import Array
from flightapp.safety.api import SafetyContext
from flightapp.safety.braking import Braking, horizontal_braking, vertical_braking
from flightapp.safety.parameters import SafetyParameters

TOP, BOTTOM = 5, 6
"""Columns of discs."""
SPARED_SHARE = 0.5
"""Of the margin: what is passed is taken for passed down to this much of it, so that noise of the height does not make an
obstacle below the vehicle come and go."""
STANDS_M_S = 0.2
"""What is said to move faster is passed by nobody: where it will be, and how high, is not known."""


@dataclass(frozen=True, slots=True)
class VerticalRates:
    """The largest rates that keep clear of what is passed; negative asks to move away, inf where nothing is near."""

    climb_max_m_s: float
    sink_max_m_s: float


def any_height_known(discs: Array) -> bool:
    """Whether any of `discs` (n, 7) ends below or above."""
    return bool(np.isfinite(discs[:, TOP:]).any())


def blocking(context: SafetyContext, parameters: SafetyParameters) -> NDArray[np.bool_]:
    """(n,): which known obstacles stand in the way of the vehicle at its height.

    All of them, where heights are not to be trusted: an own state or an obstacle picture that is too old, or an autopilot
    that does not vouch for the position.
    """
    discs = context.obstacles.discs
    trusted = (
        context.heights_trusted
        and context.own_age_s <= parameters.own_state_age_max_s
        and context.obstacles_age_s <= parameters.obstacles_age_max_s
    )
    if not (trusted and any_height_known(discs)):
        return np.ones(len(discs), dtype=np.bool_)
    over, under = _passed(context, parameters)
    return ~(over | under)


def vertical_rates(context: SafetyContext, wish_m_s: Sequence[float], parameters: SafetyParameters) -> VerticalRates:
    """The rates for a vehicle that wants to fly with the planar velocity `wish_m_s` (north, east).

    They count for what is passed and so near that the planar guard could no longer stop before it, and for what the vehicle is
    right above or below of. They hold whether or not the heights are trusted: they only ever restrict.
    """
    discs = context.obstacles.discs
    if not any_height_known(discs):
        return VerticalRates(math.inf, math.inf)
    braking, body_m = vertical_braking(parameters), context.limits.body_radius_m
    down, down_m_s = float(context.own.position_ned_m[2]), float(context.own.velocity_ned_m_s[2])
    over, under = _passed(context, parameters)
    near = _is_near(context, wish_m_s, parameters)
    beside_m = disc_clearances_m(context.own.position_ned_m[:2], discs, body_m)
    inside = beside_m <= parameters.obstacle_clearance_min_m
    above_m = discs[(over & near) | (inside & (down < discs[:, TOP])), TOP] - down - body_m
    below_m = down - discs[(under & near) | (inside & (down > discs[:, BOTTOM])), BOTTOM] - body_m
    return VerticalRates(
        _kept_m_s(below_m, -down_m_s, braking, context.own_age_s, parameters),
        _kept_m_s(above_m, down_m_s, braking, context.own_age_s, parameters),
    )


def _kept_m_s(gaps_m: Array, closing_m_s: float, braking: Braking, age_s: float, parameters: SafetyParameters) -> float:
    """The largest speed towards the nearest of surfaces that are `gaps_m` (k,) away from the body."""
    if len(gaps_m) == 0:
        return math.inf
    margin, push = parameters.obstacle_height_margin_m, parameters.push_back_m_s
    return braking.kept_m_s(float(gaps_m.min()), closing_m_s, margin, push, age_s)


def _passed(context: SafetyContext, parameters: SafetyParameters) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """(n,) each: obstacles above and below which the vehicle stays even if it began to brake its vertical motion only now."""
    discs, body_m = context.obstacles.discs, context.limits.body_radius_m
    down, down_m_s = float(context.own.position_ned_m[2]), float(context.own.velocity_ned_m_s[2])
    braking, kept_m = vertical_braking(parameters), SPARED_SHARE * parameters.obstacle_height_margin_m
    stands = (np.hypot(discs[:, 3], discs[:, 4]) <= STANDS_M_S) & (discs[:, TOP] < discs[:, BOTTOM])
    over = discs[:, TOP] - down - body_m - kept_m >= _stopping_m(down_m_s, braking, context.own_age_s)
    under = down - discs[:, BOTTOM] - body_m - kept_m >= _stopping_m(-down_m_s, braking, context.own_age_s)
    return stands & over, stands & under


def _stopping_m(closing_m_s: float, braking: Braking, age_s: float) -> float:
    """Way until a closing speed is braked, with what passes before the braking begins."""
    speed = max(0.0, closing_m_s)
    return braking.reach_m(speed, age_s) + speed * speed / (2.0 * braking.deceleration_m_s2)


def _is_near(context: SafetyContext, wish_m_s: Sequence[float], parameters: SafetyParameters) -> NDArray[np.bool_]:
    """(n,): obstacles that the planar guard could not stop before, were they to stand in the way from now on.

    The speed towards each is the largest of the present, the last and the wanted one: the vehicle is on its way between them.
    """
    discs, braking = context.obstacles.discs, horizontal_braking(context.limits, parameters)
    offset = discs[:, :2] - context.own.position_ned_m[:2]
    distance = np.hypot(offset[:, 0], offset[:, 1])
    towards = offset / np.maximum(distance, 1e-6)[:, None]
    last = context.own if context.previous is None else context.previous
    speeds = np.vstack((context.own.velocity_ned_m_s[:2], last.velocity_ned_m_s[:2], np.asarray(wish_m_s, dtype=np.float64)))
    closing = np.maximum(0.0, (towards @ speeds.T).max(axis=1))
    stop_m = (
        closing * (braking.lag_s + context.own_age_s)
        + 0.5 * braking.deceleration_m_s2 * braking.lag_s * braking.lag_s
        + closing * closing / (2.0 * braking.deceleration_m_s2)
    )
    left_m = distance - discs[:, 2] - context.limits.body_radius_m - parameters.obstacle_clearance_min_m
    near: NDArray[np.bool_] = left_m <= stop_m
    return near

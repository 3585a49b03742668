"""Timed synchronisation: when this pursuer arrives, and how an early one shapes its speed."""

from __future__ import annotations

import math
from collections.abc import Sequence

from flightapp.planning.ac2f.approach import intercept_time_s
from flightapp.planning.plane import Point


def arrival_time_s(own: Point, place: Point, velocity: Point, speed_m_s: float) -> float:
    """Estimated time until `own` with `speed_m_s` reaches a place that moves with `velocity`; straight to it if it never does."""
    time_s = intercept_time_s(own, place, velocity, speed_m_s)
    return math.dist(own, place) / speed_m_s if time_s is None else time_s


def speed_share(own_eta_s: float, team_eta_s: Sequence[float], window_s: float, share_min: float) -> float:
    """Share of the speed with which an early pursuer arrives no more than `window_s` before the last."""
    latest = max(team_eta_s, default=0.0) - window_s
    return 1.0 if latest <= own_eta_s else max(share_min, own_eta_s / latest)

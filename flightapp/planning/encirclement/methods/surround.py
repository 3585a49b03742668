"""`surround-hunt`: to the middle between both neighbours around the evader, and inwards with what speed is left.

After Fang, Wang, Xie, Chen, "Cooperative Pursuit with Multi-Pursuer and One Faster Free-moving Evader" (2022). The paper that it
is compared in gives no formulas: this is like it, not the same.
"""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.angles import TWO_PI
from flightapp.planning.encirclement.moment import Moment
from flightapp.planning.plane import Point

HUNTING_GAP_RAD = 0.9 * math.pi
TOGETHER_M = 1e-9


class SurroundHunt:
    """Spreads by the gaps to the neighbours; less so once the evader is surrounded."""

    def __init__(self, gain_1_s: float, hunting_share: float, speed_max_m_s: float) -> None:
        self._gain_1_s, self._hunting_share, self._speed_max_m_s = gain_1_s, hunting_share, speed_max_m_s

    def __call__(self, moment: Moment) -> Point:
        n, e = moment.situation.own
        out_n, out_e = n - moment.evader[0], e - moment.evader[1]
        distance = math.hypot(out_n, out_e)
        if distance < TOGETHER_M:
            return n, e
        out_n, out_e = out_n / distance, out_e / distance
        along = self._along_m_s(moment, distance)
        inwards = math.sqrt(max(0.0, self._speed_max_m_s**2 - along * along))
        horizon_s = moment.horizon_s
        return n + horizon_s * (-along * out_e - inwards * out_n), e + horizon_s * (along * out_n - inwards * out_e)

    def _along_m_s(self, moment: Moment, distance_m: float) -> float:
        """Speed around the evader, towards growing bearings."""
        team = moment.situation.team
        if len(team) == 1:
            return 0.0
        bearings = np.arctan2(team[:, 1] - moment.evader[1], team[:, 0] - moment.evader[0])
        ahead = float(((bearings[1:] - bearings[0]) % TWO_PI).min())
        behind = float(((bearings[0] - bearings[1:]) % TWO_PI).min())
        along = self._gain_1_s * distance_m * 0.5 * (ahead - behind)
        along = max(-self._speed_max_m_s, min(self._speed_max_m_s, along))
        order = np.sort(bearings)
        widest = float(np.diff(order, append=order[0] + TWO_PI).max())
        return along * self._hunting_share if widest < HUNTING_GAP_RAD else along

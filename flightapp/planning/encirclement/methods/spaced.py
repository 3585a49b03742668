"""`spaced`: equally spaced places on a circle around the evader that shrinks (after Liao, Liu, Liu, 2021)."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import linear_sum_assignment

from flightapp.core.angles import TWO_PI
from flightapp.planning.encirclement.moment import Moment
from flightapp.planning.plane import Point


class Spaced:
    """The circle begins at the pursuers' mean distance; it turns so that the places are nearest to them."""

    def __init__(self, radius_min_m: float, speed_m_s: float) -> None:
        self._radius_min_m, self._speed_m_s = radius_min_m, speed_m_s
        self._radius_m: float | None = None

    def __call__(self, moment: Moment) -> Point:
        situation = moment.situation
        offsets = situation.team - np.array(moment.evader)
        if self._radius_m is None:
            self._radius_m = float(np.hypot(offsets[:, 0], offsets[:, 1]).mean())
        else:
            self._radius_m -= self._speed_m_s * situation.period_s
        self._radius_m = max(self._radius_m, self._radius_min_m)
        count = len(offsets)
        angles = np.arctan2(offsets[:, 1], offsets[:, 0])
        turn = math.atan2(float(np.sin(count * angles).sum()), float(np.cos(count * angles).sum())) / count
        places = turn + TWO_PI / count * np.arange(count)
        ring = self._radius_m * np.stack((np.cos(places), np.sin(places)), axis=1)
        order = np.lexsort((offsets[:, 1], offsets[:, 0]))  # everybody solves the same problem
        pursuers = offsets[order]
        _, seats = linear_sum_assignment(((pursuers[:, None] - ring) ** 2).sum(axis=2))
        n, e = ring[seats[int(np.flatnonzero(order == 0)[0])]]
        return moment.evader[0] + float(n), moment.evader[1] + float(e)

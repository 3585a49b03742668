"""Out of a standstill: cells end at the plane before a large obstacle, and so do pursuers that only go to their centroids.

Not in the paper. Where no progress is made far from an evader that is not encircled, the next corner of the shortest way to the
widest gap around it is the goal, until the evader is in sight; where there is no way or it does not help either, along what
blocks, to the right (as in Zhou, Wang, Bandyopadhyay, Schwager, "Fast, on-line collision avoidance for dynamic vehicles using
buffered Voronoi cells", 2017).
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from flightapp.core.angles import TWO_PI
from flightapp.core.types import Array
from flightapp.planning.ac2f.corridor import blocking_disc
from flightapp.planning.ac2f.escape import find_way
from flightapp.planning.ac2f.recollection import blank_recollection
from flightapp.planning.encirclement.moment import Moment
from flightapp.planning.encirclement.parameters import EncirclementParameters
from flightapp.planning.encirclement.situation import DISC_SHARE
from flightapp.planning.geometry.polygons import Polygons
from flightapp.planning.plane import Point

FAR_RADII = 2.0
"""Nearer to the evader than so many capture radii, standing still is no deadlock."""
MARGIN_M = 0.05
"""The way keeps this much more from obstacles where there is room."""
REACHED_M = 0.3
"""A corner of the way counts as reached."""
LONGEST = 6
"""A way is followed for at most so many times `guided_s`."""
WALL_DISC_M = 0.1
"""A wall is searched as discs of this radius along it."""


class Standstill:
    """What one pursuer remembers of its progress, and the way that it follows."""

    def __init__(self, parameters: EncirclementParameters, speed_max_m_s: float, kept_m: float, walls: Polygons) -> None:
        self._parameters, self._speed_max_m_s, self._kept_m = parameters, speed_max_m_s, kept_m
        self._walls = wall_discs(walls)
        self._recollection = blank_recollection()
        self.reset()

    def reset(self) -> None:
        """No way, and no past."""
        self._past: deque[tuple[float, Point]] = deque()
        self._way: list[Point] = []
        self._slides = False
        self._since_s = self._until_s = -math.inf

    def goal(self, moment: Moment, goal: Point, *, encircled: bool) -> tuple[Point, str]:
        """`goal`, or what leads out of a standstill, and how: "", "guided" or "sliding"."""
        situation = moment.situation
        distance = math.dist(situation.own, moment.evader)
        if encircled or distance <= FAR_RADII * self._parameters.capture.radius_m:
            self.reset()
            return goal, ""
        t_s = situation.t_s
        if self._is_stuck(t_s, situation.own):
            was_guided = bool(self._way) and not self._slides
            self._since_s = t_s
            self._search(moment)
            self._slides = was_guided or not self._way
            self._past.clear()
        elif t_s >= self._until_s:
            if self._goes_on(moment):
                self._search(moment)
            else:
                self._way = []
            self._slides = False
        return self._follow(moment) if self._slides or self._way else (goal, "")

    def _goes_on(self, moment: Moment) -> bool:
        """Whether the way is followed for longer: the evader is still out of sight."""
        if not self._way or self._slides or moment.situation.t_s >= self._since_s + LONGEST * self._parameters.guided_s:
            return False
        discs, own = self._discs(moment), moment.situation.own
        return bool(blocking_disc(discs, len(discs), *own, *own, *moment.evader, self._kept_m) >= 0)

    def _is_stuck(self, t_s: float, own: Point) -> bool:
        """Too little progress over the window; a full one, so that nobody is stuck before it has had the time to move."""
        window_s = self._parameters.deadlock_window_s
        self._past.append((t_s, own))
        while len(self._past) > 1 and self._past[1][0] <= t_s - window_s + 1e-9:
            self._past.popleft()
        since_s, before = self._past[0]
        least = self._parameters.deadlock_progress * self._speed_max_m_s * window_s
        return t_s - since_s >= window_s - 1e-9 and math.dist(before, own) < least

    def _search(self, moment: Moment) -> None:
        """A way to the middle of the widest gap around the evader; none is left where there is none."""
        self._until_s = moment.situation.t_s + self._parameters.guided_s
        goal = self._in_area(widest_gap_place(moment))
        discs, own, cell_m = self._discs(moment), moment.situation.own, self._parameters.guidance_cell_m
        room = self._recollection
        corners = find_way(discs, len(discs), *own, *goal, self._kept_m, MARGIN_M, cell_m, room)
        self._way = [(float(n), float(e)) for n, e in room["found"][0][:corners]]

    def _in_area(self, place: Point) -> Point:
        area = self._parameters.flight_area_m
        if area is None:
            return place
        return min(max(place[0], area[0]), area[2]), min(max(place[1], area[1]), area[3])

    def _follow(self, moment: Moment) -> tuple[Point, str]:
        own = moment.situation.own
        if self._slides:
            n, e = self._blocking_normal(moment)
            reach = self._speed_max_m_s
            return moment.safe((own[0] - reach * e, own[1] + reach * n)), "sliding"
        while len(self._way) > 1 and math.dist(own, self._way[0]) < REACHED_M:
            self._way.pop(0)
        return moment.safe(self._way[0]), "guided"

    def _blocking_normal(self, moment: Moment) -> Point:
        """Of the plane with the least room."""
        planes = moment.situation.planes[: moment.situation.plane_count]
        if not len(planes):
            return 0.0, 0.0
        n, e, _ = planes[int(planes[:, 2].argmin())].tolist()
        return n, e

    def _discs(self, moment: Moment) -> Array:
        """All that stands in the way (k, 3): discs, and walls as discs."""
        rounds = moment.situation.rounds
        standing = rounds[rounds[:, 3] == DISC_SHARE][:, :3].copy()
        standing[:, 2] -= self._kept_m
        return np.ascontiguousarray(np.concatenate((standing, self._walls)))


def wall_discs(walls: Polygons) -> Array:
    """Discs (k, 3) along the edges of `walls`, none further from the next than their radius."""
    rows = [np.zeros((0, 3))]
    for first, last in zip(walls.starts[:-1], walls.starts[1:], strict=True):
        corners = walls.corners[first:last]
        for here, there in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            count = max(1, math.ceil(math.dist(here, there) / WALL_DISC_M))
            places = here + (there - here) * (np.arange(count) / count)[:, None]
            rows.append(np.column_stack((places, np.full(count, WALL_DISC_M))))
    return np.concatenate(rows)


def widest_gap_place(moment: Moment) -> Point:
    """In the middle of the widest gap between the pursuers around the evader, at half the size of the box."""
    offsets = moment.situation.team - np.array(moment.evader)
    bearings = np.sort(np.arctan2(offsets[:, 1], offsets[:, 0]))
    gaps = np.diff(bearings, append=bearings[0] + TWO_PI)
    widest = int(gaps.argmax())
    middle = float(bearings[widest] + 0.5 * gaps[widest])
    reach = max(moment.half_m)
    return moment.evader[0] + reach * math.cos(middle), moment.evader[1] + reach * math.sin(middle)

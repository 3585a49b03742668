"""What a method gets to choose a goal from: the situation, the box and both cells."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flightapp.core.types import Array
from flightapp.planning.encirclement.cells import Cells, cells
from flightapp.planning.encirclement.situation import DISC_SHARE, MATE_SHARE, Situation
from flightapp.planning.geometry.convex import nearest_in
from flightapp.planning.geometry.half_planes import PLANE_COLUMNS, add_rounds
from flightapp.planning.plane import Point


@dataclass(frozen=True, slots=True)
class Moment:
    """One decision's worth; `evader` is where the box is laid around."""

    situation: Situation
    evader: Point
    evader_velocity: Point
    half_m: Point
    horizon_s: float
    """A goal this far ahead at some velocity is flown to at that velocity."""
    cells: Cells
    safety: Array
    """(c, 2) corners of the safety cell."""
    target: Array
    """(c, 2) corners of the target cell; none where it is empty."""

    def safe(self, place: Point) -> Point:
        """The point of the safety cell nearest to `place`; the own place where there is no cell."""
        if len(self.safety) == 0:
            return self.situation.own
        n, e = nearest_in(self.safety, len(self.safety), *place)
        return n, e


Method = Callable[[Moment], Point]
"""Chooses a goal (m). Whatever it is, the way there is kept in the safety cell."""


class Cutting:
    """Computes moments, in arrays that they share: a moment is good until the next one."""

    def __init__(self) -> None:
        self._rooms = [np.zeros((64, 2)) for _ in range(3)]

    def moment(self, situation: Situation, evader: Point, evader_velocity: Point, half_m: Point, horizon_s: float) -> Moment:
        """Both cells of the own vehicle."""
        if situation.plane_count + 9 > len(self._rooms[0]):
            self._rooms = [np.zeros((2 * situation.plane_count + 9, 2)) for _ in range(3)]
        safety, target, spare = self._rooms
        found = cells(*situation.own, *evader, *half_m, situation.planes, situation.plane_count, safety, target, spare)
        kept = safety[: int(found.safety_corners)]
        corners = target[: int(found.target_corners)]
        return Moment(situation, evader, evader_velocity, half_m, horizon_s, found, kept, corners)

    def evader_area_m2(self, moment: Moment) -> float:
        """Of what is left to the evader within the box: nearer to it than to any pursuer, and before the discs."""
        situation = moment.situation
        discs = situation.rounds[situation.rounds[:, 3] == DISC_SHARE]
        rounds = np.zeros((len(situation.team) + len(discs), situation.rounds.shape[1]))
        rounds[len(situation.team) :] = discs
        rounds[: len(situation.team), :2] = situation.team
        rounds[: len(situation.team), 3] = MATE_SHARE
        planes = np.zeros((len(rounds), PLANE_COLUMNS))
        count = add_rounds(*moment.evader, rounds, len(rounds), planes, 0)
        rooms = [np.zeros((count + 9, 2)) for _ in range(3)]
        return float(cells(*moment.evader, *moment.evader, *moment.half_m, planes, count, *rooms).target_area_m2)

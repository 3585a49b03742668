"""The game about the boundary in space: the boundary is a wall, its line at all heights of a band.

The evader may cross at whatever height it likes, so the game point is the place of its dominance region that is nearest to the
wall, at the best height. At each height the regions' sections are regions of the plane, and the game at that height is the
planar one. The best value over the heights is convex, for intersections of balls and half-spaces; the evader's own height is in
all regions. So it is searched from there to the side on which it gets better. Where that is nowhere, the evader's height is the
answer: with all vehicles at one height the result is the planar game's, bit for bit.

Slower pursuers leave outsides of balls, which are not convex: there the search finds a good height, perhaps not the best.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.ac2f.apollonius_kernel import (
    FAR_M,
    PRUNE_ABOVE,
    REGION_COLUMNS,
    _contested,
    _distance_to_all,
    _gap_goal,
    _inside,
    _mark_active,
    _reached,
    _tightest,
)
from flightapp.planning.ac2f.volume.sphere import SPACE_COLUMNS, dominance_in_space, section

REACHED = -1e6
"""Added to the distance of a crossing that the evader reaches first: better for it than any place before the wall."""
EQUAL_M = 1e-9
"""A height is better only by more than this."""
PROBE_M = 0.02
GOLDEN = 0.6180339887498949
ROUNDS = 20
"""Of golden section: a band of 30 m is narrowed down to 2 mm."""

Best = tuple[float, float, float]
"""Value for the evader, the less the better, and the place."""


@compiled("UniTuple(f8,3)(f8[:,::1],f8[::1],f8,f8,f8,f8,f8[:,::1],f8[:,::1])")
def _at_height(
    regions: Array,
    stretches: Array,
    down: float,
    evader_n: float,
    evader_e: float,
    evader_d: float,
    sides: Array,
    sections: Array,
) -> Best:
    """The planar game in the sections (k, 6), which are filled, at the height `down`; FAR_M where one is empty."""
    for i in range(regions.shape[0]):
        if not section(regions[i], stretches[i] * down, sections[i]):
            return FAR_M, evader_n, evader_e
    tightest = _tightest(sections) if regions.shape[0] > PRUNE_ABOVE else sections
    reached_m, n, e = _reached(tightest, False, sides, evader_n, evader_e)
    if reached_m < FAR_M:
        return REACHED + math.hypot(reached_m, stretches[0] * (down - evader_d)), n, e
    distance, n, e = _contested(tightest, False, sides, evader_n, evader_e)
    return distance, n, e


@compiled("f8(f8[:,::1],f8[::1],f8,f8,f8,f8,f8,f8[:,::1],f8[:,::1])")
def _best_down(
    regions: Array,
    stretches: Array,
    evader_n: float,
    evader_e: float,
    evader_d: float,
    highest: float,
    lowest: float,
    sides: Array,
    sections: Array,
) -> float:
    """The height (down, m), from `highest` to `lowest`, that is best for the evader; its own where none is better."""
    own = _at_height(regions, stretches, evader_d, evader_n, evader_e, evader_d, sides, sections)[0]
    end = evader_d
    for side in range(2):
        probe = max(highest, evader_d - PROBE_M) if side == 0 else min(lowest, evader_d + PROBE_M)
        if _at_height(regions, stretches, probe, evader_n, evader_e, evader_d, sides, sections)[0] < own - EQUAL_M:
            end = highest if side == 0 else lowest
            break
    if end == evader_d:
        return evader_d
    near, far = evader_d, end
    a, b = far + GOLDEN * (near - far), near + GOLDEN * (far - near)  # a is nearer to the evader than b
    at_a = _at_height(regions, stretches, a, evader_n, evader_e, evader_d, sides, sections)[0]
    at_b = _at_height(regions, stretches, b, evader_n, evader_e, evader_d, sides, sections)[0]
    for _ in range(ROUNDS):
        if at_a <= at_b:
            far, b, at_b = b, a, at_a
            a = far + GOLDEN * (near - far)
            at_a = _at_height(regions, stretches, a, evader_n, evader_e, evader_d, sides, sections)[0]
        else:
            near, a, at_a = a, b, at_b
            b = near + GOLDEN * (far - near)
            at_b = _at_height(regions, stretches, b, evader_n, evader_e, evader_d, sides, sections)[0]
    best, at_best = (a, at_a) if at_a <= at_b else (b, at_b)
    at_end = _at_height(regions, stretches, end, evader_n, evader_e, evader_d, sides, sections)[0]
    if at_end < at_best:
        best, at_best = end, at_end
    return best if at_best < own - EQUAL_M else evader_d


@compiled(
    "Tuple((b1,f8,f8,f8,f8))(f8[:,::1],f8,f8,f8,f8[::1],f8[::1],f8[:,::1],b1,f8,f8,f8,f8[:,::1],f8[:,::1],f8[::1],f8[:,::1])"
)
def solve_in_space(
    pursuers: Array,
    evader_n: float,
    evader_e: float,
    evader_d: float,
    ratios: Array,
    stretches: Array,
    sides: Array,
    closed: bool,
    highest: float,
    lowest: float,
    spacing_m: float,
    regions: Array,
    sections: Array,
    active: Array,
    goals: Array,
) -> tuple[bool, float, float, float, float]:
    """Whether the wall is contested, and the game point's north, east, down and distance from the wall, m.

    pursuers: (k, 3) m. ratios, stretches: (k,) lambda and s of each. sides: (s, 4). highest, lowest: the band (down, m). Fills
    regions (k, 8), sections (k, 6) at the height of the game point, active (k,) and goals (k, 2) there.
    """
    for i in range(pursuers.shape[0]):
        place = pursuers[i]
        dominance_in_space(place[0], place[1], place[2], evader_n, evader_e, evader_d, ratios[i], stretches[i], regions[i])
    if closed and _inside(sides, evader_n, evader_e):
        active[:] = 1.0
        goals[:, 0] = evader_n
        goals[:, 1] = evader_e
        return False, evader_n, evader_e, evader_d, 0.0
    highest, lowest = min(highest, evader_d), max(lowest, evader_d)
    down = _best_down(regions, stretches, evader_n, evader_e, evader_d, highest, lowest, sides, sections)
    value, n, e = _at_height(regions, stretches, down, evader_n, evader_e, evader_d, sides, sections)
    tightest = _tightest(sections) if pursuers.shape[0] > PRUNE_ABOVE else sections
    _mark_active(pursuers, ratios, sections, n, e, active)
    for i in range(pursuers.shape[0]):
        goals[i, 0] = n
        goals[i, 1] = e
        if active[i] == 0.0:
            _, goals[i, 0], goals[i, 1] = _gap_goal(tightest, False, n, e, pursuers[i, 0], pursuers[i, 1], spacing_m)
    return value >= 0.0, n, e, down, _distance_to_all(sides, n, e)


@dataclass(frozen=True, slots=True)
class SpaceGame:
    """Solution for all k pursuers: the game point (north, east, down), who is active there, and everybody's goal.

    regions: (k, 8), one row a pursuer as in `sphere`. active: (k,) 1 or 0. goals: (k, 3) m.
    """

    point_ned_m: tuple[float, float, float]
    contested: bool
    """False: the evader reaches the wall first, at the point."""
    distance_m: float
    active: Array
    goals: Array
    regions: Array


def solve(
    pursuers: Array,
    evader: Sequence[float],
    ratios: Sequence[float],
    stretches: Sequence[float],
    sides: Array,
    band_down_m: tuple[float, float],
    *,
    closed: bool = False,
    goal_spacing_m: float = 3.0,
) -> SpaceGame:
    """The game for `pursuers` (k, 3) against `evader` (3,) before the wall over `sides` (s, 4), band from highest to lowest."""
    count = len(pursuers)
    regions, sections = np.empty((count, SPACE_COLUMNS)), np.empty((count, REGION_COLUMNS))
    active, goals = np.empty(count), np.empty((count, 2))
    contested, n, e, down, distance_m = solve_in_space(
        np.ascontiguousarray(pursuers, dtype=np.float64),
        float(evader[0]),
        float(evader[1]),
        float(evader[2]),
        np.array(ratios, dtype=np.float64),
        np.array(stretches, dtype=np.float64),
        sides,
        closed,
        band_down_m[0],
        band_down_m[1],
        goal_spacing_m,
        regions,
        sections,
        active,
        goals,
    )
    return SpaceGame((n, e, down), contested, distance_m, active, np.column_stack((goals, np.full(count, down))), regions)

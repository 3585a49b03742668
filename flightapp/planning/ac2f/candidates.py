"""What the dynamic window weighed in one step, thinned out for the recording: cheap enough for a control loop."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightapp.core.types import Array
from flightapp.planning.ac2f.fine import STANDING_M_S
from flightapp.planning.ac2f.records import Record

__all__ = ["KEPT", "STANDING_M_S", "Candidates", "candidates"]

KEPT = 64
"""About so many of the window's candidates are kept, evenly over its grid, and the chosen one."""
_SPEED, _TURN, _TOTAL = 0, 1, 5
"""Rows of the workspace (see `workspace_of`)."""


@dataclass(frozen=True, slots=True)
class Candidates:
    """Arcs of constant speed and turn rate, n each; verdicts: 0 admissible, 1 collides, 2 collides while braking."""

    horizon_s: float
    speeds_m_s: Array
    turns_rad_s: Array
    scores: Array
    """Weighted sums of the critics; valid where admissible."""
    verdicts: NDArray[np.int64]
    best: int | None
    """Row of the chosen one; None: none is admissible."""


def candidates(action: Record, rows: Array, verdicts: NDArray[np.int64], horizon_s: float) -> Candidates:
    """Copies of what the search left in its workspace: the next step overwrites it."""
    count = len(verdicts)
    chosen = int(action[0]["best"])
    indices = np.arange(0, count, max(1, count // KEPT))
    best = None
    if chosen >= 0:
        best = len(indices)
        indices = np.append(indices, chosen)
    kept = rows[:, indices]
    return Candidates(horizon_s, kept[_SPEED], kept[_TURN], kept[_TOTAL], verdicts[indices], best)

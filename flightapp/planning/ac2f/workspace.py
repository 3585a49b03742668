"""The arrays behind the fine stage's workspace: four of them cost less to pass to a step than ten."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.ac2f.fine import VERDICTS_TYPE, WORKSPACE_TYPE, Workspace, steps_of
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.records import ROWS

POSITIONS_TYPE = numba.types.Array(numba.float64, 3, "C")


def workspace_arrays(parameters: Ac2fParameters) -> tuple[Array, Array, Array, NDArray[np.int64]]:
    """Positions (2, steps + 1, n), rows (6, n), scores (4, n), verdicts (n,) for the n candidates of `parameters`."""
    n = parameters.speed_samples * parameters.turn_samples
    steps = steps_of(max(parameters.horizon_s, parameters.horizon_terminal_s), parameters.control_period_s)
    return np.zeros((2, steps + 1, n)), np.zeros((6, n)), np.zeros((4, n)), np.zeros(n, np.int64)


@compiled(WORKSPACE_TYPE(POSITIONS_TYPE, ROWS, ROWS, VERDICTS_TYPE))
def workspace_of(positions: Array, rows: Array, scores: Array, verdicts: NDArray[np.int64]) -> Workspace:
    """The workspace in the arrays of `workspace_arrays`."""
    return Workspace(rows[0], rows[1], positions[0], positions[1], rows[2], rows[3], rows[4], scores, rows[5], verdicts)

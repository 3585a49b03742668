"""The polar grid in the level frame of the camera into which pixels are counted: bearing bins by cells of distance."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from perception.parameters import PerceptionParameters

CELL_SIGMAS = 2.5
"""A cell is at least this many standard deviations of the depth noise deep."""
TABLE_STEP_M = 0.01
_SLANT = 1.6
"""Level forward distance of a pixel is at most this times its depth for any attitude in which perception is of use."""


class DistanceCells:
    """Cells of level forward distance that grow with the depth noise, the same in all bearing bins.

    edges_m: (cells,) near border of each; the last cell takes what is beyond and stays unused, so that neighbours in a flat
    array (bin * cells + cell) are neighbours in space. cell_of: cell number of each `TABLE_STEP_M` of distance.
    """

    def __init__(self, parameters: PerceptionParameters, range_max_m: float) -> None:
        edges = [0.0]
        while edges[-1] < _SLANT * range_max_m:
            sigma = parameters.depth_noise_1_m * edges[-1] ** 2
            edges.append(edges[-1] + max(parameters.cell_m, CELL_SIGMAS * sigma))
        self.edges_m: NDArray[np.float32] = np.array(edges, np.float32)
        centres = np.arange(int(edges[-1] / TABLE_STEP_M)) * TABLE_STEP_M + TABLE_STEP_M / 2
        self.cell_of: NDArray[np.int32] = (np.searchsorted(edges, centres, side="right") - 1).astype(np.int32)

    def __len__(self) -> int:
        return len(self.edges_m)

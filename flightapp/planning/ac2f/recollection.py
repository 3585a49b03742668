"""What one planner remembers of the discs around it, the way that it flies past them, and the room to search one: one record."""

from __future__ import annotations

import numba
import numpy as np

from flightapp.planning.ac2f.records import Record

DISCS = 256
DISC_COLUMNS = 6
BUCKETS = 512  # of the hash grid over the discs
CORNERS = 64  # of a way
SIDE = 128
CELLS = SIDE * SIDE
RING = 64
OPEN = 4 * CELLS
STEPS = 1024  # longest way in cells

RECOLLECTION = np.dtype(
    [
        ("discs", "f8", (DISCS, DISC_COLUMNS)),  # see disc_memory; memory.disc_count of them
        ("heads", "i4", (BUCKETS,)),
        ("links", "i4", (DISCS,)),
        ("way", "f8", (CORNERS, 2)),  # corners that are flown; memory.way_count of them
        ("found", "f8", (CORNERS, 2)),  # corners of the last search
        ("found_m", "f8"),  # length of that way
        ("straight_m", "f8"),  # to where it leads
        # the grid of the last search, see grid_search
        ("low_n", "f8"),  # south-west corner
        ("low_e", "f8"),
        ("ground", "u1", (CELLS,)),
        ("cost", "i4", (CELLS,)),
        ("came", "i4", (CELLS,)),
        ("steps", "i4", (STEPS,)),
        ("ring", "i4", (RING,)),
        ("open_cell", "i4", (OPEN,)),
        ("open_next", "i4", (OPEN,)),
    ],
    align=True,
)
RECOLLECTION_TYPE = numba.types.Array(numba.from_dtype(RECOLLECTION), 1, "C")


def blank_recollection() -> Record:
    """The recollection (1,) of a planner that has seen nothing."""
    return np.zeros(1, RECOLLECTION)

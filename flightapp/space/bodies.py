"""Bodies as one flat array, which is what kernels read: one row a body, `BODY_COLUMNS` float64 wide.

column          sphere      cylinder      superquadric cylinder   box
LENGTH          radius      radius        radius                  half its length, along its heading
WIDTH           -           -             exponent e              half its width
TOP, BOTTOM     down of the highest and the lowest point; -inf, +inf: without end
COS, SIN        -           -             of the heading          of the heading
V_NORTH, ...    velocity in m/s; a row says where the body is at time zero
"""

from __future__ import annotations

import numba

KIND, NORTH, EAST, LENGTH, WIDTH, TOP, BOTTOM, COS, SIN, V_NORTH, V_EAST, V_DOWN = range(12)
BODY_COLUMNS = 12

SPHERE, CYLINDER, SUPERQUADRIC, BOX = 0.0, 1.0, 2.0, 3.0

NUMBER = numba.float64
WHOLE = numba.int64
BODIES = numba.float64[:, ::1]
ROW = numba.float64[::1]
INDICES = numba.int64[::1]
GAP = numba.types.UniTuple(NUMBER, 4)  # type: ignore[no-untyped-call]
"""Signed distance in m, and its gradient (north, east, down)."""

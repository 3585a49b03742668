"""Avoidance: how near the end of a candidate is to the course that an avoidance rule asks for."""

from __future__ import annotations

import math

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.ac2f.elementary import angle


@compiled("void(f8[::1],f8[::1],f8,f8[::1])")
def avoidance_score(cosines: Array, sines: Array, course_rad: float, out: Array) -> None:
    """Fill out (n,): pi - |angle between the end heading and `course_rad`| (rad); cosines, sines (n,): that heading."""
    along_n, along_e = math.cos(course_rad), math.sin(course_rad)
    for c in range(out.shape[0]):
        along = cosines[c] * along_n + sines[c] * along_e
        across = cosines[c] * along_e - sines[c] * along_n
        out[c] = math.pi - angle(abs(across), along)

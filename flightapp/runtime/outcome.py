"""How a pursuit ends, and who decides when vehicles say different things."""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum

import numpy as np

from flightapp.core.types import Array, Boundary


class Outcome(StrEnum):
    """Result of one mission as one vehicle knows it."""

    CAPTURED = "captured"
    """The success criterion was met."""
    ESCAPED = "escaped"
    """The evader crossed the boundary."""
    TIMEOUT = "timeout"
    """The time limit passed first."""
    ABORTED = "aborted"
    """A person, or the pilot's transmitter, ended it."""
    FAULT = "fault"
    """Something failed."""


def outcome_of_team(outcomes: Iterable[str | None]) -> Outcome | None:
    """What the others' reports mean for this vehicle's pursuit; an abort or fault of one does not end it for all."""
    told = set(outcomes)
    for outcome in (Outcome.CAPTURED, Outcome.ESCAPED, Outcome.TIMEOUT):
        if outcome in told:
            return outcome
    return None


def crosses(boundary: Boundary, before_m: Array, after_m: Array) -> bool:
    """Whether the segment `before_m` -> `after_m`, (2,) each, meets the boundary."""
    starts = boundary.vertices_m
    ends = np.roll(starts, -1, axis=0)
    if not boundary.closed:
        starts, ends = starts[:-1], ends[:-1]
    edge = ends - starts
    step = after_m - before_m
    side_before = _cross(edge, before_m - starts)
    side_after = _cross(edge, after_m - starts)
    side_start = _cross(step, starts - before_m)
    side_end = _cross(step, ends - before_m)
    return bool(np.any((side_before * side_after <= 0.0) & (side_start * side_end <= 0.0) & (side_before != side_after)))


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])

"""Stretches of time in which something held."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from flightapp.core.types import Array

Mask = npt.NDArray[np.bool_]


class Span(NamedTuple):
    """Both ends included, s."""

    from_s: float
    to_s: float

    @property
    def length_s(self) -> float:
        return self.to_s - self.from_s


def spans_of(t_s: Array, holds: Mask, end_s: float | None = None, *, least_s: float = 0.0) -> list[Span]:
    """Where `holds` (n,) is true at the samples `t_s` (n,): each from its first sample to the first one after it.

    The last one reaches to `end_s`, or to the last sample. Those shorter than `least_s` are left out.
    """
    if not len(t_s):
        return []
    edges = np.flatnonzero(np.diff(np.concatenate(([0], holds.astype(np.int8), [0]))))
    times = np.append(t_s, t_s[-1] if end_s is None else max(end_s, float(t_s[-1])))
    found = [Span(float(times[first]), float(times[after])) for first, after in zip(edges[::2], edges[1::2], strict=True)]
    return [span for span in found if span.length_s >= least_s]


def within(t_s: Array, spans: Iterable[Span]) -> Mask:
    """(n,) bool: which of the times lie in one of the spans."""
    inside = np.zeros(len(t_s), dtype=bool)
    for span in spans:
        inside |= (t_s >= span.from_s) & (t_s <= span.to_s)
    return inside


def total_s(spans: Sequence[Span]) -> float:
    """Length of all of them."""
    return sum(span.length_s for span in spans)

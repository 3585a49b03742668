"""Own recent positions at a fixed rate, whatever the rate of decisions: for the memory penalty and the trap trigger.

The first `memory.history_count` rows of `history` (samples, 2) m are filled, oldest first.
"""

from __future__ import annotations

from numba import void

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.ac2f.records import MEMORY_TYPE, NUMBER, ROWS, WHOLE, Record


@compiled(void(MEMORY_TYPE, *(NUMBER,) * 4, ROWS))
def sample_position(memory: Record, t_s: float, period_s: float, north: float, east: float, history: Array) -> None:
    """Take the position if a sample is due at `t_s`; a gap in time starts the history anew."""
    m = memory[0]
    if t_s - m.history_next_s > 5.0 * period_s:
        m.history_count = 0
        m.history_next_s = t_s
    if t_s < m.history_next_s - 1e-9:
        return
    m.history_next_s += period_s
    if m.history_count == history.shape[0]:
        for i in range(history.shape[0] - 1):
            history[i, 0] = history[i + 1, 0]
            history[i, 1] = history[i + 1, 1]
        m.history_count -= 1
    history[m.history_count, 0] = north
    history[m.history_count, 1] = east
    m.history_count += 1


@compiled(NUMBER(ROWS))
def variance_m2(points: Array) -> float:
    """Trace of the covariance of `points` (k > 0, 2)."""
    north = 0.0
    east = 0.0
    for i in range(points.shape[0]):
        north += points[i, 0]
        east += points[i, 1]
    north /= points.shape[0]
    east /= points.shape[0]
    total: float = 0.0
    for i in range(points.shape[0]):
        total += (points[i, 0] - north) ** 2 + (points[i, 1] - east) ** 2
    variance: float = total / points.shape[0]
    return variance


@compiled(ROWS(ROWS, WHOLE, WHOLE))
def latest(history: Array, count: int, samples: int) -> Array:
    """The newest `samples` of the first `count` rows, fewer where there are fewer."""
    return history[max(0, count - samples) : count]

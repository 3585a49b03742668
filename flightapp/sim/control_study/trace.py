"""What the leader's trace (k, `flight.PLACES_FROM` + 3 n) of a flight says: the quantities of figures 6 to 8 and 16 to 18."""

from __future__ import annotations

import numpy as np

from flightapp.core.types import Array
from flightapp.sim.control_study.flight import PLACES_FROM

PRINTED_SLOPE_1_S = 35.0


def error_of(trace: Array) -> Array:
    """(k,): how far the leader is from its reference, m."""
    return np.asarray(np.linalg.norm(trace[:, 10:13], axis=1), dtype=np.float64)


def sliding_of(trace: Array) -> Array:
    """(k,): |rate + 35 error| of the leader, m/s: the printed sliding variable."""
    return np.asarray(np.linalg.norm(trace[:, 13:16] + PRINTED_SLOPE_1_S * trace[:, 10:13], axis=1), dtype=np.float64)


def lyapunov_of(trace: Array) -> Array:
    """(k,): (|e|^2 + |its rate|^2) / 2 of the leader, what the source prints as its Lyapunov function."""
    return np.asarray(0.5 * (trace[:, 10:16] ** 2).sum(axis=1), dtype=np.float64)


def places_of(trace: Array) -> Array:
    """(k, n, 3): where every vehicle was, NED in m; the leader first."""
    return trace[:, PLACES_FROM:].reshape(len(trace), -1, 3)

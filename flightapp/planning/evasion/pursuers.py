"""The pursuers as rows, from the observation."""

from __future__ import annotations

import numpy as np

from flightapp.core.types import Array, Observation

PREDICTION_MAX_S = 1.0


def pursuer_rows(observation: Observation) -> Array:
    """(k, 4) north, east (m), v_north, v_east (m/s) of the pursuers, predicted from the time of their states to the present."""
    rows = np.empty((len(observation.team), 4))
    for row, member in zip(rows, observation.team, strict=True):
        ahead_s = min(PREDICTION_MAX_S, max(0.0, observation.t_s - member.state.t_s))
        north, east, _ = member.state.position_ned_m.tolist()
        v_north, v_east, _ = member.state.velocity_ned_m_s.tolist()
        row[:] = (north + ahead_s * v_north, east + ahead_s * v_east, v_north, v_east)
    return rows

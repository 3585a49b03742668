"""The pursuers as rows, from the observation's team."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flightapp.core.types import Array, TeamMember

PREDICTION_MAX_S = 1.0


def pursuer_rows(team: Sequence[TeamMember]) -> Array:
    """(k, 4) north, east (m), v_north, v_east (m/s) of the pursuers, predicted over the age of their states."""
    rows = np.empty((len(team), 4))
    for row, member in zip(rows, team, strict=True):
        ahead_s = min(PREDICTION_MAX_S, max(0.0, member.age_s))
        north, east, _ = member.state.position_ned_m.tolist()
        v_north, v_east, _ = member.state.velocity_ned_m_s.tolist()
        row[:] = (north + ahead_s * v_north, east + ahead_s * v_east, v_north, v_east)
    return rows

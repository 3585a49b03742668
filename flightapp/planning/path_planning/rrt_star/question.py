"""What the growing tree is asked, as one NumPy record that its kernels read; a record costs the compiler less than arguments."""

from __future__ import annotations

from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

QUESTION_FIELDS = (
    "start_n",
    "start_e",
    "start_d",
    "goal_n",
    "goal_e",
    "goal_d",
    "low_n",
    "low_e",
    "low_d",
    "high_n",
    "high_e",
    "high_d",
    "gap_m",  # which every way keeps from the bodies at rest
    "moving_gap_m",  # which it keeps from those that move, as they are predicted
    "step_m",
    "radius_max_m",
    "radius_factor",  # of the smallest radius for which RRT* converges
    "goal_share",  # of samples that are the goal itself
    "informed",  # 1: samples only where a shorter way can lead, once there is one
    "push_share",  # of the force that moves a sample; 0: samples stay where they fell
    "push_gain",
    "push_reach_m",
    "speed_max_m_s",
    "acceleration_m_s2",
)
"""All float64: m, m/s, m/s^2, NED."""
QUESTION_RECORD = np.dtype([(name, "f8") for name in QUESTION_FIELDS])
QUESTION = numba.from_dtype(QUESTION_RECORD)
Question = Any
"""Such a record; its fields are QUESTION_FIELDS."""


def question(**fields: float) -> Question:
    """The record; every field must be given."""
    one: NDArray[np.void] = np.array([tuple(fields[name] for name in QUESTION_FIELDS)], dtype=QUESTION_RECORD)
    return one[0]

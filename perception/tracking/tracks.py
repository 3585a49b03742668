"""What is kept of every disc, and the numbers that the compiled steps of tracking read by name."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from perception.parameters import PerceptionParameters

Records = NDArray[np.void]

TRACK = np.dtype(
    [
        # State of the constant-velocity filter at `updated_s`, in the mission frame; covariance in the order of these four.
        ("north_m", "f8"),
        ("east_m", "f8"),
        ("v_north_m_s", "f8"),
        ("v_east_m_s", "f8"),
        ("covariance", "f8", (4, 4)),
        ("updated_s", "f8"),
        ("radius_m", "f8"),
        # The same state predicted to the newest frame.
        ("now_north_m", "f8"),
        ("now_east_m", "f8"),
        ("now_v_north_m_s", "f8"),
        ("now_v_east_m_s", "f8"),
        ("now_covariance", "f8", (4, 4)),
        ("now_radius_m", "f8"),
        ("first_s", "f8"),
        ("seen_s", "f8"),
        ("confidence", "f8"),
        ("hits", "i8"),  # frames in which it was seen
        ("seen_through", "i8"),  # frames since then in which something was seen beyond it
        ("is_whole", "i8"),  # one whole object: only such a disc may get a velocity
        ("is_moving", "i8"),  # its movement is proven
        ("moved_frames", "i8"),  # frames in a row that spoke for movement
        ("is_withheld", "i8"),  # inside an exclusion now
        # Two earlier states, older first, against which movement is proven.
        ("anchor_s", "f8", (2,)),
        ("anchor_north_m", "f8", (2,)),
        ("anchor_east_m", "f8", (2,)),
        ("anchor_radius_m", "f8", (2,)),
        ("anchor_sight_north_m", "f8", (2,)),  # from the camera of that time to the disc
        ("anchor_sight_east_m", "f8", (2,)),
        ("anchor_variance_nn", "f8", (2,)),
        ("anchor_variance_ne", "f8", (2,)),
        ("anchor_variance_ee", "f8", (2,)),
    ],
    align=True,
)

RULES_FIELDS = (
    "depth_noise_1_m",
    "surface_tolerance_m",
    "memory_growth_m_s",
    "memory_growth_moving_m_s",
    "association_m",
    "bearing_error_deg",
    "moving_speed_min_m_s",
    "moving_after_s",
    "manoeuvre_m_s2",
)
RULES = np.dtype([(name, "f8") for name in RULES_FIELDS])

TRACKS_TYPE = numba.types.Array(numba.from_dtype(TRACK), 1, "C")
RULES_TYPE = numba.types.Array(numba.from_dtype(RULES), 1, "C")


def rules_of(parameters: PerceptionParameters) -> Records:
    """(1,) record of the parameters that compiled steps need."""
    return np.array([tuple(getattr(parameters, name) for name in RULES_FIELDS)], RULES)

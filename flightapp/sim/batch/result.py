"""What one episode came to."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Outcome = Literal["captured", "collided", "escaped", "timed_out"]


@dataclass(frozen=True, slots=True)
class RunResult:
    """Everything but `decision_ns` and `sim_wall_ns` follows, bit for bit, from scenario, planner, parameters and seed."""

    scenario: str
    planner: str
    seed: int
    outcome: Outcome
    collided_with: str
    """"obstacle", "teammate" or ""."""
    duration_s: float
    capture_time_s: float | None
    path_length_m: float
    """Mean over the pursuers."""
    mean_jerk_m_s3: float
    """Mean of the jerk's magnitude over pursuers and control periods."""
    boundary_distance_m: float
    """The evader's from the boundary at the end; 0 where it crossed."""
    min_clearance_m: float
    """Smallest distance of a pursuer's surface to an obstacle's surface, at any time; inf where none was near."""
    min_separation_m: float
    """Smallest distance between the centres of two pursuers, at any time; inf for one."""
    decision_ns: NDArray[np.int64]
    """Processor time of one decision of each control period, the pursuers in turn; where somebody looks on, of every decision,
    and 0 of who is lost."""
    mode_share: dict[str, float]
    """Share of the pursuers' control periods in each mode."""
    shortest_path_m: float | None
    """Of the first pursuer to capture, where the layout knows it."""
    sim_wall_ns: int
    """Wall time of the whole episode."""
    encircled_first_s: float | None = None
    """When the evader was first inside the hull of the pursuers (widest gap below pi), seen at the ends of control periods."""
    encircled_share: float = 0.0
    """Share of the time in which it was."""
    encircled_at_capture: bool | None = None
    """Whether it was when it was captured; None where it was not captured."""
    travel_m: float = 0.0
    """Sum of the pursuers' path lengths."""
    turning_rad: float = 0.0
    """Sum of the pursuers' changes of heading without their sign."""
    lost: int = 0
    """Pursuers that failed."""
    decisions: int = 0
    """Made by all pursuers."""
    flag_share: dict[str, float] = field(default_factory=dict)
    """Share of them that tell each flag: what is not as the strategy wants it."""

"""Durations of the election. All of them are measured by one member's own clock from one event to another; offsets cancel."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Timing:
    """Defaults: a round trip of 0.4 s still holds a lease, a dead leader is replaced in about 1 s.

    clock_drift_max: how much faster or slower than true a clock may run; 0.05 is a thousand times what a quartz does, and leaves
    room for the period with which a control loop looks at its clock.
    """

    beacon_period_s: float = 0.1
    lease_s: float = 0.6
    timeout_min_s: float = 0.7
    timeout_max_s: float = 1.0
    clock_drift_max: float = 0.05

    def __post_init__(self) -> None:
        """ValueError where a leader's lease could outlast the promises that it rests on."""
        longest_lease_s = self.lease_s / (1.0 - self.clock_drift_max)
        shortest_promise_s = self.timeout_min_s / (1.0 + self.clock_drift_max)
        if longest_lease_s > shortest_promise_s:
            raise ValueError(
                f"lease_s {self.lease_s:g} with clocks {self.clock_drift_max:g} off may last {longest_lease_s:.3f} s, longer "
                f"than timeout_min_s {self.timeout_min_s:g}, which may last {shortest_promise_s:.3f} s: make the lease shorter"
            )
        if not 0.0 < self.beacon_period_s < self.lease_s or not self.timeout_min_s < self.timeout_max_s:
            raise ValueError("durations must rise: 0 < beacon_period_s < lease_s < timeout_min_s < timeout_max_s")

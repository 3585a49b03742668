"""How far another machine's clock is ahead of the own, from the round trips of questions for its time. Free of input and output.

A question sent at a and answered at b (own clock) with the other's time r shows r - (a + b) / 2. Where the ways there and back
take different times, that is wrong by half their difference: at most half the round trip, which is the uncertainty given here.
No measurement by round trips can see more: a link that is always slower in one direction shifts it by half the difference.

The quickest of recent answers is the best. Its uncertainty grows by what two crystals drift apart, so that in time a newer one
replaces it. An answer that contradicts it (a machine that was restarted or set) makes the older ones void.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

WINDOW_S = 60.0
DRIFT_MAX = 1e-4
"""s/s between two clocks: crystals of small computers are within 50 ppm each, and NTP slews a clock by as much."""
STEP_TOLERANCE_S = 0.005
"""Beyond their uncertainties, before two answers contradict each other."""


@dataclass(frozen=True, slots=True)
class RoundTrip:
    """`asked_s` and `answered_s`: own clock; `remote_s`: what the other's clock said."""

    asked_s: float
    remote_s: float
    answered_s: float

    @property
    def ahead_s(self) -> float:
        return self.remote_s - (self.asked_s + self.answered_s) / 2.0

    @property
    def uncertainty_s(self) -> float:
        return (self.answered_s - self.asked_s) / 2.0

    def uncertainty_at_s(self, now_s: float) -> float:
        """With what the clocks may have drifted apart since."""
        return self.uncertainty_s + DRIFT_MAX * max(0.0, now_s - self.answered_s)


@dataclass(frozen=True, slots=True)
class Offset:
    """The other's clock is ahead of the own by `ahead_s`, give or take `uncertainty_s`."""

    ahead_s: float
    uncertainty_s: float


class ClockOffset:
    """Of one other machine."""

    def __init__(self) -> None:
        self._trips: deque[RoundTrip] = deque()
        self.steps = 0
        """How often the other's clock was found to have jumped."""

    def note(self, trip: RoundTrip) -> None:
        """An answer came. Impossible ones, answered before asked, are passed over."""
        if trip.answered_s < trip.asked_s:
            return
        best = self._best(trip.answered_s)
        if best is not None and _contradict(best, trip):
            self._trips.clear()
            self.steps += 1
        self._trips.append(trip)

    def offset(self, now_s: float) -> Offset | None:
        """The best that is known at `now_s`; None before the first answer. Old answers count until there are newer ones."""
        best = self._best(now_s)
        return None if best is None else Offset(best.ahead_s, best.uncertainty_at_s(now_s))

    def _best(self, now_s: float) -> RoundTrip | None:
        while len(self._trips) > 1 and now_s - self._trips[0].answered_s > WINDOW_S:
            self._trips.popleft()
        return min(self._trips, key=lambda trip: trip.uncertainty_at_s(now_s), default=None)


def _contradict(best: RoundTrip, trip: RoundTrip) -> bool:
    allowed_s = best.uncertainty_at_s(trip.answered_s) + trip.uncertainty_s + STEP_TOLERANCE_S
    return abs(best.ahead_s - trip.ahead_s) > allowed_s

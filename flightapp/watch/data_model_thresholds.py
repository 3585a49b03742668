"""From where on a figure is worth a colour, a word or an alarm."""

from __future__ import annotations

from dataclasses import dataclass

from flightapp.config.profile import Profile

STATE_RATE_HZ = 20.0
LOST_AGE_S = 0.7
LOST_PERIODS = 5
"""As the vehicles themselves judge a silent teammate: see `runtime.teamwork`."""


@dataclass(frozen=True, slots=True)
class Thresholds:
    """Defaults: of the default profile."""

    late_age_s: float = LOST_AGE_S / 2.0
    lost_age_s: float = LOST_AGE_S
    clearance_min_m: float = 0.5
    guard_long_s: float = 3.0
    clock_ahead_max_s: float = 1.0
    """A machine whose clock is further off was not synchronised."""


def thresholds_of(profile: Profile | None) -> Thresholds:
    """As `profile` sets them, where there is one."""
    if profile is None:
        return Thresholds()
    lost_s = max(LOST_AGE_S, LOST_PERIODS / profile.network.state_rate_hz)
    return Thresholds(lost_s / 2.0, lost_s, profile.limits.safety_margin_m)

"""From where on a figure is worth a colour, a word or an alarm."""

from __future__ import annotations

from dataclasses import dataclass

from flightapp.config.profile import Profile
from flightapp.fleet.roster import LOST_AGE_S, lost_age_s
from flightapp.fleet.shared_state import SharedState


@dataclass(frozen=True, slots=True)
class Thresholds:
    """Defaults: of the default profile."""

    late_age_s: float = LOST_AGE_S / 2.0
    lost_age_s: float = LOST_AGE_S
    clearance_min_m: float = 0.5
    battery_reserve_fraction: float = 0.2
    battery_critical_fraction: float = 0.1
    guard_long_s: float = 3.0
    clock_ahead_max_s: float = 1.0
    """A machine whose clock is further off was not synchronised."""

    def lost_age_of_s(self, state: SharedState) -> float:
        """From when on the sender of `state` counts as lost: as its mates judge it, by when it said that the next one is due."""
        return self.lost_age_s if state.due_s <= 0.0 else max(self.lost_age_s, lost_age_s(1.0 / state.due_s))

    def late_age_of_s(self, state: SharedState) -> float:
        """And as late."""
        return self.late_age_s * self.lost_age_of_s(state) / self.lost_age_s


def thresholds_of(profile: Profile | None) -> Thresholds:
    """As `profile` sets them, where there is one."""
    if profile is None:
        return Thresholds()
    lost_s = lost_age_s(profile.network.state_rate_hz)
    safety = profile.safety
    return Thresholds(
        lost_s / 2.0,
        lost_s,
        profile.limits.safety_margin_m,
        safety.battery_reserve_fraction,
        safety.battery_critical_fraction,
    )

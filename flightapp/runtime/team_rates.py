"""How often which mate gets the own state, by this vehicle's profile and guards."""

from __future__ import annotations

from flightapp.config.profile import Profile
from flightapp.core.types import Limits
from flightapp.fleet.state_rates import Need, StateRates, fast_count
from flightapp.safety.braking import horizontal_braking


def state_rates(vehicles: int, profile: Profile, limits: Limits) -> StateRates:
    """Of each of so many vehicles: separation and braking are those of the guard, the budget is the profile's."""
    network, safety = profile.network, profile.safety
    need = Need(
        keep_m=safety.separation_min_m + safety.separation_buffer_m + safety.separation_passing_m,
        acceleration_max_m_s2=limits.acceleration_max_m_s2,
        widening_max_m=safety.team_widening_max_m,
        stop_m=horizontal_braking(limits, safety).stop_m,
        silent_s=safety.team_state_age_max_s,
    )
    closed = network.certificates is not None
    count = fast_count(vehicles, network.state_rate_hz, network.fleet_kbit_s_max, closed=closed)
    return StateRates(network.state_rate_hz, count, need)

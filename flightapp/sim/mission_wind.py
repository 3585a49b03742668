"""The wind that a mission file describes, as the mock autopilot's multirotor takes it."""

from __future__ import annotations

from flightapp.config.mission import Simulation
from flightapp.sim.multirotor import Wind


def wind_of(simulation: Simulation, seed: int) -> Wind:
    """The same air for all vehicles of the mission flown with `seed`."""
    mean = (simulation.wind_north_m_s, simulation.wind_east_m_s, simulation.gust_m_s)
    if simulation.harmonic_wind is None:
        return Wind(*mean)
    from flightapp.sim.wind import air  # compiled: a mock without such a wind starts without it

    return Wind(*mean, air=air(simulation.harmonic_wind, seed))

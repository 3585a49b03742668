"""ORCA, as the package pyrvo computes it, among the same discs: what a reactive method of the field costs on this machine."""

from __future__ import annotations

from typing import Any

from flightapp.bench.measurement import Measurement, Work, measure
from flightapp.bench.situation import DISCS, far
from flightapp.core.types import Limits, Observation
from flightapp.planning.plane import limited, planar

ORCA_STEP = f"pyrvo, ORCA step alone, {DISCS} neighbours"
ORCA_DECISION = f"pyrvo, ORCA from an observation, {DISCS} discs"

NEIGHBOUR_DISTANCE_M = 20.0
TIME_HORIZON_S = 2.0


def orca_measurements(limits: Limits, seconds: float) -> list[Measurement] | None:
    """The step alone, and all of a decision as a planner takes it: discs of the observation in, step, velocity out.

    None where pyrvo is not installed.
    """
    try:
        import pyrvo
    except ImportError:
        return None
    own = _simulator(pyrvo, limits)

    def told(k: int) -> None:
        _tell(own, far(k), limits)

    def step(_: None) -> None:
        own.do_step()

    def decide(seen: Observation) -> object:
        _tell(own, seen, limits)
        own.do_step()
        return own.get_agent_velocity(0)

    alone = measure(Work(ORCA_STEP, told, step), seconds / 2)
    neighbours = own.get_agent_num_agent_neighbors(0)
    if neighbours != DISCS:
        raise RuntimeError(f"ORCA saw {neighbours} neighbours instead of {DISCS}: this would measure something else")
    return [alone, measure(Work(ORCA_DECISION, far, decide), seconds / 2)]


def _simulator(pyrvo: Any, limits: Limits) -> Any:
    """One agent that heeds all others, which heed nobody: only its linear programme is solved."""
    simulator = pyrvo.RVOSimulator()
    simulator.set_time_step(0.1)
    radius = limits.body_radius_m + limits.safety_margin_m
    horizons = (TIME_HORIZON_S, TIME_HORIZON_S)
    simulator.add_agent((0.0, 0.0), NEIGHBOUR_DISTANCE_M, DISCS, *horizons, radius, limits.speed_max_m_s)
    for k in range(DISCS):
        simulator.add_agent((1.0, float(k)), NEIGHBOUR_DISTANCE_M, 0, *horizons, 0.5, 1.0)
    return simulator


def _tell(simulator: Any, seen: Observation, limits: Limits) -> None:
    """Place and velocity of everything that is observed, radii, and the wish to fly at the evader."""
    own, target = planar(seen.own.position_ned_m), seen.target
    simulator.set_agent_position(0, own)
    simulator.set_agent_velocity(0, planar(seen.own.velocity_ned_m_s))
    if target is not None:
        north, east = planar(target.position_ned_m)
        simulator.set_agent_pref_velocity(0, limited((north - own[0], east - own[1]), limits.speed_max_m_s))
    for agent, (north, east, radius, v_north, v_east, *_) in enumerate(seen.obstacles.discs.tolist(), 1):
        simulator.set_agent_position(agent, (north, east))
        simulator.set_agent_velocity(agent, (v_north, v_east))
        simulator.set_agent_radius(agent, radius)

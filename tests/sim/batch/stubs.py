"""Vehicles that fly one command for ever, and worlds for them without a family."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from flightapp.core.types import Boundary, Decision
from flightapp.sim.batch.families.layout import Area, Layout, Start, disc_rows
from flightapp.sim.batch.scenario import Scenario, load_scenario
from flightapp.sim.batch.world import World

SCENARIOS = Path(__file__).parents[3] / "missions" / "scenarios"
AREA = Area(-100.0, 100.0, -100.0, 100.0)
FAR = Boundary(np.array([[-99.0, -99.0], [-99.0, 99.0]]), False)


def scenario(name: str = "a2-dense", **overrides: object) -> Scenario:
    """A scenario of the repository; `sensing__range_m=5` overrides sensing.range_m."""
    return load_scenario(SCENARIOS / f"{name}.toml", {key.replace("__", "."): _toml(value) for key, value in overrides.items()})


def _toml(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else repr(value)


def world(of: Scenario, pursuers: list[Start], evader: Start, discs: list[list[float]], boundary: Boundary = FAR) -> World:
    """The world of `of` with everything at given places."""
    return World(of, Layout(disc_rows(discs), boundary, tuple(pursuers), evader, AREA), 1, 2)


def command(north_m_s: float, east_m_s: float, yaw_rad: float | None = None) -> Decision:
    """A decision with this velocity, nose along it."""
    yaw = math.atan2(east_m_s, north_m_s) if yaw_rad is None else yaw_rad
    return Decision(np.array((north_m_s, east_m_s, 0.0)), None, yaw, "coarse", None)


def set_moving(of: World, index: int, north_m_s: float, east_m_s: float) -> None:
    """Give a vehicle its velocity at once."""
    vehicle = of.vehicles[index]
    vehicle["vn"], vehicle["ve"], vehicle["speed"] = north_m_s, east_m_s, math.hypot(north_m_s, east_m_s)
    vehicle["yaw"] = math.atan2(east_m_s, north_m_s)

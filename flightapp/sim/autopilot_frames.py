"""The mock's three frames: mission NED (its own state), geodetic, and the local NED about its own origin."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flightapp.core.geodesy import (
    GeodeticPoint,
    geodetic_to_mission,
    geodetic_to_px4_local,
    mission_to_geodetic,
    px4_local_to_geodetic,
)
from flightapp.sim.multirotor import Vector


@dataclass(frozen=True, slots=True)
class Frames:
    """Datum of the mission frame and local origin of this autopilot. North is the same direction in both."""

    datum: GeodeticPoint
    origin: GeodeticPoint

    def to_geodetic(self, position_ned_m: Vector) -> GeodeticPoint:
        return mission_to_geodetic(self.datum, np.array(position_ned_m))

    def to_local(self, position_ned_m: Vector) -> Vector:
        return self.geodetic_to_local(self.to_geodetic(position_ned_m))

    def geodetic_to_local(self, point: GeodeticPoint) -> Vector:
        return _floats(geodetic_to_px4_local(self.origin, point).tolist())

    def geodetic_to_mission(self, point: GeodeticPoint) -> Vector:
        return _floats(geodetic_to_mission(self.datum, point).tolist())

    def from_local(self, position_ned_m: Vector) -> Vector:
        """Mission-frame position of a position in the autopilot's local frame."""
        return self.geodetic_to_mission(px4_local_to_geodetic(self.origin, np.array(position_ned_m)))


def displaced_origin(datum: GeodeticPoint, offset_m: float, index: int) -> GeodeticPoint:
    """Local origin of vehicle number `index`: `offset_m` from the datum, each in another direction and at another height."""
    bearing = math.radians(35.0 + 137.5 * index)
    down_m = (-3.0, 4.0, 7.0, -6.0, 1.5)[index % 5] if offset_m > 0.0 else 0.0
    return mission_to_geodetic(datum, np.array([offset_m * math.cos(bearing), offset_m * math.sin(bearing), down_m]))


def _floats(values: list[float]) -> Vector:
    return (values[0], values[1], values[2])

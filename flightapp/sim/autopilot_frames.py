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

_ANCHOR_REACH_M = 20.0
"""Around an anchor this far the geodetic position is linear in the mission frame to better than 0.1 mm."""


@dataclass(frozen=True, slots=True)
class _Anchor:
    """A point where the exact conversion and its derivatives were taken."""

    north_m: float
    east_m: float
    latitude_deg: float
    longitude_deg: float
    latitude_per_north: float
    latitude_per_east: float
    longitude_per_north: float
    longitude_per_east: float


class Frames:
    """Datum of the mission frame and local origin of this autopilot. North is the same direction in both."""

    def __init__(self, datum: GeodeticPoint, origin: GeodeticPoint) -> None:
        self.datum = datum
        self.origin = origin
        self._anchor = self._anchor_at(0.0, 0.0)

    def to_geodetic(self, position_ned_m: Vector) -> GeodeticPoint:
        anchor = self._anchor
        north, east = position_ned_m[0] - anchor.north_m, position_ned_m[1] - anchor.east_m
        if abs(north) > _ANCHOR_REACH_M or abs(east) > _ANCHOR_REACH_M:
            anchor = self._anchor = self._anchor_at(position_ned_m[0], position_ned_m[1])
            north = east = 0.0
        return GeodeticPoint(
            anchor.latitude_deg + north * anchor.latitude_per_north + east * anchor.latitude_per_east,
            anchor.longitude_deg + north * anchor.longitude_per_north + east * anchor.longitude_per_east,
            self.datum.altitude_m - position_ned_m[2],
        )

    def _anchor_at(self, north_m: float, east_m: float) -> _Anchor:
        def exact(north: float, east: float) -> GeodeticPoint:
            return mission_to_geodetic(self.datum, np.array([north, east, 0.0]))

        reach, span = _ANCHOR_REACH_M, 2.0 * _ANCHOR_REACH_M
        centre = exact(north_m, east_m)
        before_n, after_n = exact(north_m - reach, east_m), exact(north_m + reach, east_m)
        before_e, after_e = exact(north_m, east_m - reach), exact(north_m, east_m + reach)
        return _Anchor(
            north_m,
            east_m,
            centre.latitude_deg,
            centre.longitude_deg,
            (after_n.latitude_deg - before_n.latitude_deg) / span,
            (after_e.latitude_deg - before_e.latitude_deg) / span,
            (after_n.longitude_deg - before_n.longitude_deg) / span,
            (after_e.longitude_deg - before_e.longitude_deg) / span,
        )

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

"""Between an autopilot's local frame, geodetic coordinates and the fleet's mission frame.

PX4 projects latitude and longitude onto its local plane with an azimuthal equidistant projection on a *sphere* of
6 371 000 m (PX4 `lib/geo`), so its local metres are undone with the same sphere. The mission frame itself is a tangent
plane on the WGS84 ellipsoid: true metres, the same for every vehicle wherever its own origin is. Undoing PX4's metres with
the ellipsoid as well would shift vehicles with origins 1 km apart against each other: by 3.0 m east to west and 2.1 m
diagonally at latitude 47 degrees, by up to 5.5 m at the equator. The sphere for both would keep vehicles consistent with each
other, but every surveyed position would be off by the same 3 to 5.5 m a kilometre.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pymap3d

from flightapp.core.types import Array

PX4_EARTH_RADIUS_M = 6_371_000.0


@dataclass(frozen=True, slots=True)
class GeodeticPoint:
    """WGS84 latitude and longitude in degrees, altitude above mean sea level in metres."""

    latitude_deg: float
    longitude_deg: float
    altitude_m: float


def px4_local_to_geodetic(origin: GeodeticPoint, local_ned_m: Array) -> GeodeticPoint:
    """Geodetic point of a position (3,) in the local NED frame of a PX4 whose origin is `origin`."""
    north, east = float(local_ned_m[0]) / PX4_EARTH_RADIUS_M, float(local_ned_m[1]) / PX4_EARTH_RADIUS_M
    arc = math.hypot(north, east)
    if arc == 0.0:
        return GeodeticPoint(origin.latitude_deg, origin.longitude_deg, origin.altitude_m - float(local_ned_m[2]))
    lat0 = math.radians(origin.latitude_deg)
    sin_arc, cos_arc = math.sin(arc), math.cos(arc)
    lat = math.asin(cos_arc * math.sin(lat0) + north * sin_arc * math.cos(lat0) / arc)
    lon = math.radians(origin.longitude_deg) + math.atan2(
        east * sin_arc, arc * math.cos(lat0) * cos_arc - north * math.sin(lat0) * sin_arc
    )
    return GeodeticPoint(math.degrees(lat), math.degrees(lon), origin.altitude_m - float(local_ned_m[2]))


def geodetic_to_px4_local(origin: GeodeticPoint, point: GeodeticPoint) -> Array:
    """Position (3,) that a PX4 with local origin `origin` reports at `point` (inverse of `px4_local_to_geodetic`)."""
    lat0, lat = math.radians(origin.latitude_deg), math.radians(point.latitude_deg)
    d_lon = math.radians(point.longitude_deg - origin.longitude_deg)
    cos_arc = math.sin(lat0) * math.sin(lat) + math.cos(lat0) * math.cos(lat) * math.cos(d_lon)
    arc = math.acos(min(1.0, max(-1.0, cos_arc)))
    scale = PX4_EARTH_RADIUS_M * (arc / math.sin(arc) if arc > 0.0 else 1.0)
    north = scale * (math.cos(lat0) * math.sin(lat) - math.sin(lat0) * math.cos(lat) * math.cos(d_lon))
    east = scale * math.cos(lat) * math.sin(d_lon)
    return np.array([north, east, origin.altitude_m - point.altitude_m])


def geodetic_to_mission(datum: GeodeticPoint, point: GeodeticPoint) -> Array:
    """Position (3,) NED in the mission frame about `datum`; down is the difference of altitudes (no Earth curvature)."""
    north, east, _ = pymap3d.geodetic2ned(
        point.latitude_deg, point.longitude_deg, datum.altitude_m, datum.latitude_deg, datum.longitude_deg, datum.altitude_m
    )
    return np.array([float(north), float(east), datum.altitude_m - point.altitude_m])


def mission_to_geodetic(datum: GeodeticPoint, position_ned_m: Array) -> GeodeticPoint:
    """Geodetic point of a mission-frame position (3,); inverse of `geodetic_to_mission`."""
    latitude, longitude, _ = pymap3d.ned2geodetic(
        float(position_ned_m[0]), float(position_ned_m[1]), 0.0, datum.latitude_deg, datum.longitude_deg, datum.altitude_m
    )
    return GeodeticPoint(float(latitude), float(longitude), datum.altitude_m - float(position_ned_m[2]))

"""Never outside the contingency volume."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely

from flightapp.config.mission import FlightVolume
from flightapp.core.types import Array
from flightapp.sim.fault_campaign.attribution import answers_until_s
from flightapp.sim.fault_campaign.trace import Finding, Trace


def contingency(trace: Trace) -> Iterator[Finding]:
    """No vehicle is truly outside the contingency volume while the app answers for where it flies."""
    for one in trace.vehicles.values():
        answered = one.states[:, 0] < answers_until_s(trace, one.name)
        outside = outside_m(trace.mission.flight_volume, one.states[:, 1:4])
        wrong = np.flatnonzero(answered & ~one.on_ground & (outside > 0.0))
        if wrong.size:
            worst = float(outside[wrong].max())
            yield Finding(one.name, float(one.states[wrong[0], 0]), f"{worst:.2f} m outside the contingency volume")


def outside_m(volume: FlightVolume, positions_ned_m: Array) -> Array:
    """How far (n,) positions (n, 3) lie outside the contingency volume; not positive inside."""
    points = shapely.points(positions_ned_m[:, 0], positions_ned_m[:, 1])
    if volume.contingency_vertices_m is None:
        planar = shapely.distance(shapely.Polygon(volume.vertices_m), points) - volume.contingency_m
    else:
        planar = shapely.distance(shapely.Polygon(volume.contingency_vertices_m), points)
    above = -positions_ned_m[:, 2] - volume.height_max_m - volume.contingency_height_m
    outside: Array = np.maximum(planar, above)
    return outside

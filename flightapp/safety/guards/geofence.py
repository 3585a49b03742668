"""The fence around the flight volume."""

from __future__ import annotations

import math
from collections.abc import Sequence

from flightapp.core.types import Setpoint
from flightapp.safety.api import GuardVerdict, SafetyContext
from flightapp.safety.braking import horizontal_braking
from flightapp.safety.guards.spatial import check_alone
from flightapp.safety.parameters import SafetyParameters
from flightapp.safety.velocity_bounds import Planar, VelocityBound

ON_THE_LINE_M = 1e-6


class GeofenceGuard:
    """Specification: inside the polygon, the speed towards the nearest point of each edge is at most what can be braked
    `fence_margin_m` before it; outside, the speed away from the nearest point of the fence is at most zero. Zero velocity
    always passes. Any simple polygon will do, convex or not: an edge is an obstacle of zero width. Mission frame, (north, east).
    """

    name = "geofence"

    def __init__(self, vertices_m: Sequence[tuple[float, float]], parameters: SafetyParameters) -> None:
        self._parameters = parameters
        self._margin_m = parameters.fence_margin_m
        area2 = 0.0
        pairs = list(zip(vertices_m, [*vertices_m[1:], vertices_m[0]], strict=True))
        for (n0, e0), (n1, e1) in pairs:
            area2 += n0 * e1 - n1 * e0
        turn = 1.0 if area2 > 0.0 else -1.0
        self._edges: list[tuple[float, float, float, float, float, float, float]] = []
        for (n0, e0), (n1, e1) in pairs:
            length = math.hypot(n1 - n0, e1 - e0)
            if length > 0.0:
                along_n, along_e = (n1 - n0) / length, (e1 - e0) / length
                self._edges.append((n0, e0, along_n, along_e, length, turn * along_e, -turn * along_n))

    def check(self, setpoint: Setpoint, context: SafetyContext) -> GuardVerdict:
        return check_alone(self, setpoint, context)

    def bounds(self, wish: Planar, speed_m_s: float, context: SafetyContext) -> list[VelocityBound]:  # noqa: ARG002
        north, east, _ = context.own.position_ned_m.tolist()
        v_north, v_east, _ = context.own.velocity_ned_m_s.tolist()
        braking = horizontal_braking(context.limits, self._parameters)
        inside = False
        nearest = (math.inf, 0.0, 0.0)
        found: list[VelocityBound] = []
        for n0, e0, along_n, along_e, length, out_n, out_e in self._edges:
            n1, e1 = n0 + length * along_n, e0 + length * along_e
            if (e0 > east) != (e1 > east) and north < n0 + (east - e0) * (n1 - n0) / (e1 - e0):
                inside = not inside
            along = min(max((north - n0) * along_n + (east - e0) * along_e, 0.0), length)
            to_n, to_e = n0 + along * along_n - north, e0 + along * along_e - east
            distance = math.hypot(to_n, to_e)
            to_n, to_e = (to_n / distance, to_e / distance) if distance > ON_THE_LINE_M else (out_n, out_e)
            if distance < nearest[0]:
                nearest = (distance, to_n, to_e)
            left = distance - self._margin_m - braking.reach_m(to_n * v_north + to_e * v_east, context.own_age_s)
            bound = braking.speed_m_s(left)
            if bound < speed_m_s:
                found.append(VelocityBound(to_n, to_e, bound, self.name, "fence", distance))
        if inside or nearest[0] <= ON_THE_LINE_M:
            return found
        distance, to_n, to_e = nearest
        return [VelocityBound(-to_n, -to_e, 0.0, self.name, "outside the fence, which is", distance)]

"""The fence around the flight volume, in the plane."""

from __future__ import annotations

import math
from collections.abc import Sequence

from flightapp.core.types import Setpoint
from flightapp.safety.api import GuardVerdict, SafetyContext
from flightapp.safety.braking import horizontal_braking
from flightapp.safety.guards.spatial import check_alone
from flightapp.safety.outline import Outline
from flightapp.safety.parameters import SafetyParameters
from flightapp.safety.velocity_bounds import Planar, VelocityBound


class GeofenceGuard:
    """Specification, for each edge of the polygon by its nearest point; x is how far inside it the vehicle is:

    - x beyond half of `fence_margin_m`: the speed towards the edge is at most what can be braked `fence_margin_m` before it.
    - x nearer than that, or outside (there the nearest point of the whole fence counts): the vehicle is pushed back,
      at (margin / 2 - x) / (2 lag) less what its own motion inwards covers in half of that time, at most `push_back_m_s`.

    The bound falls steadily with x, so there is nothing to switch at the line and noise of the own position cannot make it
    swing. Any simple polygon will do, convex or not: an edge is an obstacle of zero width. Mission frame, (north, east).
    """

    name = "geofence"

    def __init__(self, vertices_m: Sequence[tuple[float, float]], parameters: SafetyParameters) -> None:
        self._parameters = parameters
        self._margin_m = parameters.fence_margin_m
        self._outline = Outline(vertices_m)

    def check(self, setpoint: Setpoint, context: SafetyContext) -> GuardVerdict:
        return check_alone(self, setpoint, context)

    def bounds(self, wish: Planar, speed_m_s: float, context: SafetyContext) -> list[VelocityBound]:  # noqa: ARG002
        north, east, _ = context.own.position_ned_m.tolist()
        v_north, v_east, _ = context.own.velocity_ned_m_s.tolist()
        braking, age = horizontal_braking(context.limits, self._parameters), context.own_age_s
        fastest = max(speed_m_s, math.hypot(v_north, v_east))
        look = self._outline.seen_from(north, east, self._margin_m + braking.stop_m(fastest) + fastest * age)
        push = self._parameters.push_back_m_s
        if not look.is_inside:
            to_n, to_e, distance = look.nearest
            closing = -to_n * v_north - to_e * v_east
            bound = braking.kept_m_s(-distance, closing, self._margin_m, push, age)
            text = f"outside the fence, {distance:.1f} m: going back at {-bound:.1f} m/s"
            return [VelocityBound(-to_n, -to_e, bound, self.name, "fence", distance, text)]
        found = []
        for to_n, to_e, distance in look.near:
            bound = braking.kept_m_s(distance, to_n * v_north + to_e * v_east, self._margin_m, push, age)
            if bound < speed_m_s:
                found.append(VelocityBound(to_n, to_e, bound, self.name, "fence", distance))
        return found

"""Beyond the flight volume: hold within the contingency volume, land or terminate outside it."""

from __future__ import annotations

import math
from collections.abc import Sequence

from flightapp.core.types import Setpoint, VehicleState
from flightapp.safety.api import Action, Demand, GuardVerdict, SafetyContext
from flightapp.safety.duration import Duration
from flightapp.safety.guards.setpoints import with_velocity
from flightapp.safety.outline import Outline

CONFIRMED_S = 0.2
"""A single wrong position asks for nothing."""
RETURNED_S = 1.0
HOLD_WITHIN_M = 1.0


class ContingencyGuard:
    """Specification; beyond means outside the flight volume's polygon or above its top, by the own position:

    - Beyond the flight volume the planar setpoint is scaled down, to nothing 1 m beyond: the vehicle holds, and the push back of
      fence and height band remains. The scale falls steadily, so that there is nothing to switch at the line.
    - Beyond it for 0.2 s: HOLD is asked for, until the vehicle was inside for 1 s.
    - Outside the contingency volume for 0.2 s: `outside_action` is asked for and never taken back.

    The contingency volume reaches `contingency_m` around the polygon, or is a polygon of its own, and `contingency_height_m`
    above the top. Below the bottom there is none: the ground is there, and the height band alone pushes back.
    Mission frame; heights are metres above the datum.
    """

    name = "contingency"

    def __init__(
        self,
        vertices_m: Sequence[tuple[float, float]],
        height_max_m: float,
        *,
        contingency_m: float,
        contingency_height_m: float,
        contingency_vertices_m: Sequence[tuple[float, float]] | None = None,
        outside_action: Action = Action.LAND,
    ) -> None:
        self._flight = Outline(vertices_m)
        self._contingency = None if contingency_vertices_m is None else Outline(contingency_vertices_m)
        self._top_m = height_max_m
        self._around_m, self._above_m = contingency_m, contingency_height_m
        self._outside_action = outside_action
        self._beyond, self._outside, self._back = Duration(), Duration(), Duration()
        self._holding = False
        self._ended = ""
        self._standing: Demand | None = None
        self._judged_own: VehicleState | None = None
        self._beyond_now_m = (0.0, 0.0)

    def check(self, setpoint: Setpoint, context: SafetyContext) -> GuardVerdict:
        beyond = max(self._beyond_m(context))
        north, east, down = setpoint.velocity_ned_m_s.tolist()
        if beyond <= 0.0 or north == east == 0.0:
            return GuardVerdict(setpoint)
        scale = max(0.0, 1.0 - beyond / HOLD_WITHIN_M)
        reason = f"{beyond:.1f} m beyond the flight volume: holding"
        return GuardVerdict(with_velocity(setpoint, north * scale, east * scale, down), reason)

    def demand(self, context: SafetyContext) -> Demand | None:
        planar, above = self._beyond_m(context)
        beyond = max(planar, above)
        if not math.isfinite(beyond):  # Where the vehicle is, is not known: nothing is confirmed, and nothing taken back.
            return self._standing
        self._standing = self._judged(planar, above, beyond, context)
        return self._standing

    def _judged(self, planar: float, above: float, beyond: float, context: SafetyContext) -> Demand | None:
        if self._outside.of(self._is_outside(planar, above, context), context.dt_s) >= CONFIRMED_S and not self._ended:
            self._ended = f"outside the contingency volume, {beyond:.1f} m beyond the flight volume"
        if self._ended:
            return Demand(self._outside_action, self.name, self._ended)
        self._holding |= self._beyond.of(beyond > 0.0, context.dt_s) >= CONFIRMED_S
        self._holding &= self._back.of(beyond <= 0.0, context.dt_s) < RETURNED_S
        if self._holding:
            return Demand(Action.HOLD, self.name, f"beyond the flight volume: {max(beyond, 0.0):.1f} m")
        return None

    def _beyond_m(self, context: SafetyContext) -> tuple[float, float]:
        """How far outside the polygon and how far above the top; negative inside. Kept for the second asking in one period."""
        if self._judged_own is not context.own:
            north, east, down = context.own.position_ned_m.tolist()
            self._beyond_now_m = -self._flight.seen_from(north, east, 0.0).inside_m, -down - self._top_m
            self._judged_own = context.own
        return self._beyond_now_m

    def _is_outside(self, planar_m: float, above_m: float, context: SafetyContext) -> bool:
        if above_m > self._above_m:
            return True
        if self._contingency is None:
            return planar_m > self._around_m
        north, east, _ = context.own.position_ned_m.tolist()
        return planar_m > 0.0 and not self._contingency.seen_from(north, east, 0.0).is_inside

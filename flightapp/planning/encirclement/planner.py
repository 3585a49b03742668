"""The pursuer of `oa-ecbvc` and of the methods beside it: look, judge the encirclement, cut cells, choose a goal, stay safe.

Nobody leads: what several vehicles must agree on, the box, follows from what each of them observes and from the others' modes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flightapp.core.angles import wrap_pi
from flightapp.core.types import Array, Decision, Limits, Observation
from flightapp.planning.encirclement.box import Box
from flightapp.planning.encirclement.capture_watch import CaptureWatch
from flightapp.planning.encirclement.cells import Dynamics, held_velocity
from flightapp.planning.encirclement.moment import Cutting, Method, Moment
from flightapp.planning.encirclement.parameters import EncirclementParameters
from flightapp.planning.encirclement.primitives import Primitives
from flightapp.planning.encirclement.situation import Evader, Looking, Situation
from flightapp.planning.encirclement.standstill import Standstill
from flightapp.planning.encirclement.unicycle import nose_first
from flightapp.planning.geometry.convex import AREA_MIN_M2
from flightapp.planning.geometry.half_planes import PLANE_COLUMNS
from flightapp.planning.geometry.hull import hull_distance_m
from flightapp.planning.plane import Point, limited

ENCIRCLE, CAPTURE, DONE, SEARCH, HOLD = "encircle", "capture", "done", "search", "hold"
"""The modes that a decision carries and teammates hear."""
APPROACH_GAIN_1_S = 1.25
FACING_SPEED_M_S = 0.5
AT_THE_GOAL_M = 1e-9
VIOLATED_M = -1e-9


@dataclass(frozen=True, slots=True)
class Motion:
    """A command: m/s, rad, m/s2, and for a primitive where it comes from."""

    velocity: Point
    yaw_rad: float
    acceleration: Array | None = None
    source: str = ""


class EncirclementPlanner:
    """One pursuer. Nothing in it is random."""

    def __init__(self, *, limits: Limits, parameters: EncirclementParameters, method: Callable[[], Method]) -> None:
        self._limits, self._parameters = limits, parameters
        self._looking, self._cutting = Looking(limits, parameters), Cutting()
        self._make_method = method
        self._deceleration_m_s2 = limits.acceleration_max_m_s2 * parameters.braking_share
        self._primitives = Primitives(limits, parameters.jerk_weight, parameters.goal_weight)
        self._at_once = parameters.vehicle == "single-integrator"
        share = parameters.evader_feed_forward
        self._feed_forward = (0.0 if self._at_once else 1.0) if share is None else share
        separation_m = parameters.team_separation_m or 2.0 * (limits.body_radius_m + limits.safety_margin_m)
        self._box = Box(parameters, limits.speed_max_m_s, separation_m / 2.0)
        self._speeds, self._corners, self._spare = np.zeros((64, PLANE_COLUMNS)), np.zeros((64, 2)), np.zeros((64, 2))
        self._standstill = Standstill(parameters, limits.speed_max_m_s, self._looking.kept_m, self._looking.walls)
        self.reset()

    def reset(self, seed: int | None = None) -> None:
        """Forget everything."""
        del seed
        self._box.reset()
        self._method = self._make_method()
        self._standstill.reset()
        self._primitives.reset()
        self._watch = CaptureWatch(self._parameters.capture)
        self._mode = ""

    def step(self, observation: Observation) -> Decision:
        """One decision; see the module."""
        situation = self._looking.look(observation)
        if situation.evader is None:
            return self._hold(situation)
        return self._pursue(situation, situation.evader)

    def _hold(self, situation: Situation) -> Decision:
        """Without an idea of where the evader is: stand, clear of everything."""
        motion = self._motion(situation, (0.0, 0.0), situation.own)
        diagnostics: dict[str, object] = {"stage": HOLD, "flags": self._flags(situation, None, crowded=False)}
        return self._decision(motion, None, HOLD, "the target was never seen or is lost", diagnostics)

    def _pursue(self, situation: Situation, evader: Evader) -> Decision:
        hull_m = hull_distance_m(situation.team, *evader.place)
        distances = np.hypot(situation.team[:, 0] - evader.place[0], situation.team[:, 1] - evader.place[1])
        is_seen = evader.age_s <= self._parameters.target_stale_s
        captured = self._watch.captured(situation.t_s, situation.team, distances, evader.place, is_seen)
        latched = any(mode in (CAPTURE, DONE) for mode in situation.mate_modes)
        half_m = self._box.half_sizes_m(
            situation.t_s, situation.period_s, situation.team, evader.place, evader.age_s, hull_m, latched
        )
        _, crowded = self._box.half_min_m(len(situation.team), 0.0)
        lead_s = situation.lag_s
        ahead = (evader.place[0] + lead_s * evader.velocity[0], evader.place[1] + lead_s * evader.velocity[1])
        moment = self._cutting.moment(situation, ahead, evader.velocity, half_m, 1.0 / self._gain_1_s(situation))
        mode = self._next_mode(evader, captured)
        goal = evader.place if mode == SEARCH else self._method(moment)
        way = ""
        if self._parameters.deadlock and mode == ENCIRCLE:
            goal, way = self._standstill.goal(moment, goal, encircled=hull_m < 0.0)
        drift = (0.0, 0.0) if mode == SEARCH else evader.velocity
        motion = self._motion(situation, self._wish(situation, drift, goal), self._place_to_rest(moment, drift, goal))
        diagnostics: dict[str, object] = {
            "stage": mode,
            "target_distance_m": float(distances[0]),
            "hull_distance_m": hull_m if math.isfinite(hull_m) else None,
            "encircled": hull_m < 0.0,
            "captured": captured,
            "box_half_m": list(half_m),
            "cell_area_m2": moment.cells.target_area_m2,
            "evader_area_m2": self._cutting.evader_area_m2(moment),
            "slack_m": float(situation.planes[0, 2]) if situation.plane_count else None,
            "guidance": way,
            "flags": self._flags(situation, moment, crowded=crowded),
        }
        if motion.source:
            diagnostics["primitive"] = motion.source
        return self._decision(motion, goal, mode, self._reason(mode, evader, hull_m), diagnostics)

    def _next_mode(self, evader: Evader, captured: bool) -> str:
        if captured:
            return DONE
        if evader.age_s >= self._parameters.target_search_s:
            return SEARCH
        return ENCIRCLE if self._box.since_s is None else CAPTURE

    def _reason(self, mode: str, evader: Evader, hull_m: float) -> str:
        if mode == DONE:
            return "the capture rule is met"
        if mode == SEARCH:
            return f"the target was last seen {evader.age_s:.1f} s ago"
        if mode == CAPTURE:
            return f"the evader is {-hull_m:.1f} m inside the pursuers' hull" if hull_m < 0.0 else "a teammate saw it encircled"
        return "the evader is not encircled"

    def _wish(self, situation: Situation, drift: Point, goal: Point) -> Point:
        """To the goal, which moves by `drift` (m/s), at top speed; slower only where it would be passed."""
        gain = self._gain_1_s(situation)
        share = self._feed_forward
        n = gain * (goal[0] - situation.own[0]) + share * drift[0]
        e = gain * (goal[1] - situation.own[1]) + share * drift[1]
        return limited((n, e), self._limits.speed_max_m_s) if math.hypot(n, e) > AT_THE_GOAL_M else (0.0, 0.0)

    def _place_to_rest(self, moment: Moment, drift: Point, goal: Point) -> Point:
        """Where a motion to rest leads: to where the goal will be, for one that rests where it is now lags behind for ever."""
        lead_s = self._parameters.primitive_lead_s
        if self._parameters.vehicle != "triple-integrator" or drift == (0.0, 0.0):
            return goal
        return moment.safe((goal[0] + lead_s * drift[0], goal[1] + lead_s * drift[1]))

    def _gain_1_s(self, situation: Situation) -> float:
        return self._parameters.approach_gain_1_s or (1.0 / situation.period_s if self._at_once else APPROACH_GAIN_1_S)

    def _motion(self, situation: Situation, wish: Point, goal: Point) -> Motion:
        """What the vehicle can fly of it, as it can; `goal`: where a motion to rest leads."""
        if self._parameters.vehicle == "triple-integrator":
            velocity, acceleration, source = self._primitives.step(situation, goal)
            n, e = (velocity + self._parameters.primitive_lag_s * acceleration).tolist()
            n, e = limited((n, e), self._limits.speed_max_m_s)
            return Motion((n, e), self._yaw_rad(situation, (n, e)), acceleration, source)
        held = self._held(situation, wish)
        if self._parameters.vehicle == "unicycle":
            held, yaw_rad = nose_first(situation, held, self._limits, self._deceleration_m_s2)
            return Motion(held, yaw_rad)
        return Motion(held, self._yaw_rad(situation, held))

    def _held(self, situation: Situation, wish: Point) -> Point:
        """What of `wish` keeps the vehicle in its safety cell."""
        parameters, limits = self._parameters, self._limits
        deceleration = 0.0 if self._at_once else self._deceleration_m_s2
        dynamics = Dynamics(
            limits.speed_max_m_s,
            situation.period_s,
            deceleration,
            max(situation.period_s, parameters.reaction_s - situation.lag_s),
            parameters.leaving_gain_per_s,
            parameters.leaving_speed_max_m_s,
        )
        if situation.held_count + 9 > len(self._speeds):
            size = 2 * situation.held_count + 9
            self._speeds, self._corners, self._spare = np.zeros((size, PLANE_COLUMNS)), np.zeros((size, 2)), np.zeros((size, 2))
        planes, count = situation.planes, situation.held_count
        n, e = held_velocity(*wish, planes, count, dynamics, self._speeds, self._corners, self._spare)
        return n, e

    def _flags(self, situation: Situation, moment: Moment | None, *, crowded: bool) -> list[str]:
        """What is not as the method wants it, by name."""
        flags = [*self._looking.walls.warnings, *situation.flags]
        if situation.plane_count and situation.planes[: situation.plane_count, 2].min() < VIOLATED_M:
            flags.append("violation")
        if moment is not None:
            if len(moment.safety) == 0:
                flags.append("no safe place")
            elif moment.cells.target_area_m2 < AREA_MIN_M2:
                flags.append("empty cell")
        if len(situation.team) < 3:
            flags.append("cannot encircle")
        if self._parameters.evader_speed_assumed_m_s >= self._limits.speed_max_m_s:
            flags.append("no guarantee")
        if self._parameters.capture.radius_m <= self._limits.body_radius_m + self._parameters.evader_radius_m:
            flags.append("capture by contact")
        if crowded:
            flags.append("crowded")
        return flags

    def _decision(
        self,
        motion: Motion,
        goal: Point | None,
        mode: str,
        reason: str,
        diagnostics: dict[str, object],
    ) -> Decision:
        changed, self._mode = mode != self._mode, mode
        return Decision(
            velocity_ned_m_s=np.array((*motion.velocity, 0.0)),
            acceleration_ned_m_s2=None if motion.acceleration is None else np.array((*motion.acceleration, 0.0)),
            yaw_rad=wrap_pi(motion.yaw_rad),
            mode=mode,
            goal_ned_m=None if goal is None else np.array((*goal, 0.0)),
            reason=reason if changed else "",
            diagnostics=diagnostics,
        )

    def _yaw_rad(self, situation: Situation, velocity: Point) -> float:
        """Nose along the way; at rest towards the evader."""
        if math.hypot(*velocity) > FACING_SPEED_M_S or situation.evader is None:
            moving = math.hypot(*velocity) > AT_THE_GOAL_M
            return math.atan2(velocity[1], velocity[0]) if moving else situation.yaw_rad
        n, e = situation.evader.place
        return math.atan2(e - situation.own[1], n - situation.own[0])

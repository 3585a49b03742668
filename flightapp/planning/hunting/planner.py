"""CPPPEA: one hunter. It takes its part of the team's plan, or plans alone, and flies there by the widened dynamic window."""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.angles import wrap_pi
from flightapp.core.types import Decision, Limits, Observation, Rendezvous
from flightapp.planning.ac2f.free_gap import free_gap_rad
from flightapp.planning.critics.right_hand import right_turn_rad
from flightapp.planning.guidance.tree import is_barred
from flightapp.planning.hunting.guide import Guide
from flightapp.planning.hunting.hunt import Hunt, Hunter, plan_hunt, rules_of, trailing_hunt
from flightapp.planning.hunting.intent import HOLD, SEARCH, Intent, held_out_m, intend
from flightapp.planning.hunting.judge import Judge
from flightapp.planning.hunting.parameters import HuntingParameters
from flightapp.planning.hunting.sight import Sight, View
from flightapp.planning.hunting.status import Status
from flightapp.planning.hunting.window import MOTION, STATE, choose
from flightapp.planning.meeting import rest_turn_s
from flightapp.planning.plane import Point, towards
from flightapp.planning.prediction import TrackHistory

ALONE = ""
"""The own name in plans that are made alone: an observation does not tell it."""
APART_SHARE = 0.8
"""Of a separation that is asked for, kept from teammates everywhere; on the ring it is all of it."""
PERIOD_MIN_S, PERIOD_MAX_S = 0.01, 1.0
"""Of control: what an observation says of it is taken within these bounds."""
LEAVING_SHARE = 0.3
"""Of the top speed, for leaving what the vehicle is inside of."""
LEAVING_ASIDE_RAD = tuple(math.radians(sign * turn) for turn in (0.0, 30.0, 60.0, 85.0) for sign in (1.0, -1.0))[1:]
TURNING_SHARE = 0.8
"""Of the sharpest turn."""


class HuntingPlanner:
    """The strategy `hunting` and its baselines (Li et al. 2025)."""

    def __init__(self, *, limits: Limits, parameters: HuntingParameters, seed: int) -> None:
        self._limits, self._parameters, self._seed = limits, parameters, seed
        self._rules = rules_of(parameters, limits)
        self._motion = motion_record(parameters, limits)
        count = (parameters.speed_samples + 2) * (parameters.turn_samples + 3)
        self._speeds, self._turns, self._totals = np.zeros(count), np.zeros(count), np.zeros(count)
        self._ends, self._scores, self._verdicts = np.zeros((7, count)), np.zeros((4, count)), np.zeros(count, np.int64)
        self._discs = np.zeros((0, 5))
        bodies = self._rules.bodies
        self._touching_m = 2.0 * limits.body_radius_m
        self._rule_m = (
            self._touching_m
            + limits.speed_max_m_s * rest_turn_s(0.25 * math.pi, limits.yaw_rate_max_rad_s, limits.yaw_acceleration_max_rad_s2)
            + limits.speed_max_m_s**2 / (2.0 * limits.acceleration_max_m_s2)
        )
        margin_m = min(limits.safety_margin_m, 0.5 * bodies.separation_m)
        apart_m = self._touching_m + (margin_m if parameters.separation_m is None else APART_SHARE * parameters.separation_m)
        keep_out_m = limits.body_radius_m + parameters.evader_radius_m + 0.5 * bodies.separation_m
        range_m = parameters.obstacle_range_m or 50.0
        is_first = parameters.capture.mode == "first"
        self._sight = Sight(parameters, limits, range_m, apart_m, 0.0 if is_first else keep_out_m)
        self._status = Status(not is_first, parameters.team_stale_s)
        self.reset()

    def reset(self, seed: int | None = None) -> None:
        """Forget everything."""
        self._seed = self._seed if seed is None else seed
        self._sight.reset()
        self._status.reset()
        self._history = TrackHistory()
        self._judge = Judge(self._parameters.capture, self._parameters.target_stale_s)
        self._guide = Guide(self._parameters, self._limits, self._seed)
        self._state = np.zeros(1, STATE)
        self._hunt: Hunt | None = None
        self._plan_due_s = -math.inf
        self._phase = HOLD
        self._course_rad: float | None = None
        self._seen: tuple[float, Point] | None = None

    def step(self, observation: Observation) -> Decision:
        """One decision; see the class."""
        view = self._sight.look(observation)
        self._period_s = min(PERIOD_MAX_S, max(PERIOD_MIN_S, observation.dt_s or self._parameters.control_period_s))
        if observation.target is not None and observation.target.age_s <= self._parameters.target_stale_s:
            north, east, _ = observation.target.position_ned_m.tolist()
            self._history.note(observation.target.t_s, (north, east), observation.t_s)
            self._seen = view.t_s - observation.target.age_s, view.target_m
            if math.hypot(*view.target_m_s) > 0.05 * self._limits.speed_max_m_s:
                self._course_rad = math.atan2(view.target_m_s[1], view.target_m_s[0])
        self._judge.step(view)
        self._status.hear(observation)
        intent, rendezvous = self._intent(observation, view)
        guided = self._guide.step(view, intent, self._parameters.guidance)
        if guided is not None:
            direction = towards(view.own_m, guided)
            speed = self._limits.speed_max_m_s
            intent = Intent(intent.phase, guided, (speed * direction[0], speed * direction[1]), intent.facing_rad)
        velocity, yaw_rad = self._fly(view, intent)
        self._sight.commanded(*velocity, yaw_rad)
        return self._decision(view, intent, rendezvous, velocity, yaw_rad, guided)

    def _intent(self, observation: Observation, view: View) -> tuple[Intent, Rendezvous | None]:
        parameters = self._parameters
        age_s = math.inf if self._seen is None else view.t_s - self._seen[0]
        if self._seen is None or age_s > parameters.target_stale_s:
            return self._blind(view, age_s), None
        share = self._share(observation, view)
        rendezvous, bearing_rad = share
        separation_m = self._rules.bodies.separation_m
        out_m = held_out_m(rendezvous, bearing_rad, view.target_m, parameters.evader_radius_m, separation_m)
        follows = parameters.goal == "target" or self._status.lacks_quorum
        return intend(view, rendezvous, bearing_rad, out_m, parameters.capture, self._limits, follows, self._period_s), rendezvous

    def _blind(self, view: View, age_s: float) -> Intent:
        """Without a fresh target: to where it was; when it is lost, outwards with the age of what is known, facing out."""
        if self._seen is None:
            return Intent(HOLD, view.own_m, (0.0, 0.0), view.course_rad)
        place = self._seen[1]
        if age_s > self._parameters.target_lost_s:
            away = math.atan2(view.own_m[1] - place[1], view.own_m[0] - place[0])
            reach = min(self._parameters.evader_speed_assumed_m_s * age_s, self._parameters.guidance_range_m)
            place = place[0] + reach * math.cos(away), place[1] + reach * math.sin(away)
        distance, direction = math.dist(view.own_m, place), towards(view.own_m, place)
        if distance < self._limits.body_radius_m:
            return Intent(SEARCH, place, (0.0, 0.0), wrap_pi(view.course_rad + 0.5))
        speed = min(self._limits.speed_max_m_s, distance)
        return Intent(SEARCH, place, (speed * direction[0], speed * direction[1]), view.course_rad)

    def _share(self, observation: Observation, view: View) -> tuple[Rendezvous, float]:
        """The own part of the leader's plan, or of one made alone."""
        assignment = observation.assignment
        if assignment is not None and assignment.rendezvous is not None:
            self._hunt = None
            return assignment.rendezvous, assignment.bearing_rad
        if self._parameters.goal == "target":
            return self._tracking(observation, view)
        if self._status.lacks_quorum:
            return self._trailing(observation, view)
        if self._hunt is None or view.t_s >= self._plan_due_s - 1e-6:
            self._plan_due_s = view.t_s + self._parameters.plan_period_s
            self._hunt = self._planned(observation, view)
        place = self._hunt.places[ALONE]
        return rendezvous_of(self._hunt, ALONE), place.bearing_rad

    def _planned(self, observation: Observation, view: View) -> Hunt:
        hunters = hunters_of(observation, self._parameters.team_stale_s, self._limits.speed_max_m_s)
        course = self._target_course_rad(view, hunters)
        fit = self._history.fit(view.t_s)
        standing = observation.obstacles.discs
        return plan_hunt(view.t_s, view.target_m, course, fit, hunters, standing, self._rules, self._hunt)

    def _tracking(self, observation: Observation, view: View) -> tuple[Rendezvous, float]:
        """Slots around the target as it is; who takes which is settled once, by the shortest ways."""
        hunters = hunters_of(observation, self._parameters.team_stale_s, self._limits.speed_max_m_s)
        course = self._target_course_rad(view, hunters)
        if self._hunt is None or len(self._hunt.places) != len(hunters):
            self._hunt = plan_hunt(view.t_s, view.target_m, course, None, hunters, np.zeros((0, 7)), self._rules, None)
        hunt = self._hunt
        place = hunt.places[ALONE]
        rendezvous = Rendezvous(*view.target_m, course, hunt.radius_m, hunt.slots, place.slot, closing=True)
        if not self._parameters.slots:
            return rendezvous, math.atan2(view.own_m[1] - view.target_m[1], view.own_m[0] - view.target_m[0])
        return rendezvous, wrap_pi(place.bearing_rad - hunt.heading_rad + course)

    def _trailing(self, observation: Observation, view: View) -> tuple[Rendezvous, float]:
        """One behind the other behind the target: where a majority that is not heard leaves room, whatever its number."""
        hunters = hunters_of(observation, self._parameters.team_stale_s, self._limits.speed_max_m_s)
        course = self._target_course_rad(view, hunters)
        self._hunt = trailing_hunt(view.t_s, view.target_m, course, hunters, self._rules)
        return rendezvous_of(self._hunt, ALONE), self._hunt.places[ALONE].bearing_rad

    def _target_course_rad(self, view: View, hunters: tuple[Hunter, ...]) -> float:
        """Of its motion; before it moved the bearing from the team's middle to it."""
        if self._course_rad is not None:
            return self._course_rad
        north = view.target_m[0] - sum(hunter.place_m[0] for hunter in hunters) / len(hunters)
        east = view.target_m[1] - sum(hunter.place_m[1] for hunter in hunters) / len(hunters)
        return math.atan2(east, north)

    def _fly(self, view: View, intent: Intent) -> tuple[Point, float]:
        """Velocity (m/s) and yaw of this control period."""
        allowed_m = min(self._parameters.leave_first_m, 0.5 * self._limits.safety_margin_m)
        if view.depth_m > allowed_m + self._sight.lag_m:
            return self._leave(view)
        motion, state = self._motion[0], self._state[0]
        motion["period_s"] = self._period_s
        if self._parameters.window == "cycle":
            motion["window_s"] = self._period_s
        state["n"], state["e"] = view.ahead_m
        state["course"], state["speed"] = view.course_rad, min(view.speed_m_s, self._limits.speed_max_m_s)
        if view.speed_m_s < 1e-3:
            state["turn"] = min(abs(float(state["turn"])), 0.5 * self._limits.yaw_rate_max_rad_s) * math.copysign(
                1.0, state["turn"]
            )
        speed = math.hypot(*intent.velocity_m_s)
        facing = math.atan2(intent.velocity_m_s[1], intent.velocity_m_s[0]) if speed > 0.0 else intent.facing_rad
        far_m = 3.0 * self._limits.speed_max_m_s * float(motion["horizon_s"])
        state["aim_n"] = view.ahead_m[0] + far_m * math.cos(facing)
        state["aim_e"] = view.ahead_m[1] + far_m * math.sin(facing)
        state["wanted_speed"] = speed if intent.moves else min(speed, self._turning_m_s(view, intent.goal_m, facing))
        self._give_way(view, intent)
        if len(self._discs) < len(view.scene):
            self._discs = np.zeros((2 * len(view.scene), 5))
        choose(
            self._motion, self._state, view.scene, self._parameters.steps, self._parameters.speed_samples,
            self._parameters.turn_samples, self._discs, self._speeds, self._turns, self._ends, self._scores, self._totals,
            self._verdicts,
        )  # fmt: skip
        if state["best"] < 0 and view.speed_m_s < 1e-3:
            return self._look_around(view)
        course = wrap_pi(view.course_rad + float(state["first_turn"]) * self._period_s)
        state["turn"] = state["first_turn"]
        first = float(state["first_speed"])
        return (first * math.cos(course), first * math.sin(course)), course

    def _turning_m_s(self, view: View, goal: Point, wished_rad: float) -> float:
        """The speed at which the goal is not inside the vehicle's turning circle: faster, it would go round it for ever."""
        error = min(abs(wrap_pi(wished_rad - view.course_rad)), 0.5 * math.pi)
        if error < 0.05:
            return math.inf
        radius = math.dist(view.own_m, goal) / (2.0 * math.sin(error))
        limits = self._limits
        return TURNING_SHARE * min(math.sqrt(limits.acceleration_max_m_s2 * radius), limits.yaw_rate_max_rad_s * radius)

    def _give_way(self, view: View, intent: Intent) -> None:
        """The right-hand rule, on the way to the slots; on the ring everybody keeps its own."""
        state = self._state[0]
        turn = 0.0
        if self._parameters.right_hand and intent.phase not in ("form", "enclose"):
            turn = right_turn_rad(view.team, *view.own_m, *view.base_m_s, view.course_rad, self._rule_m, 1.5 * self._rule_m)
        state["avoid_weight"] = self._parameters.weight_avoidance if turn > 0.0 else 0.0
        state["avoid_course"] = view.course_rad + turn

    def _leave(self, view: View) -> tuple[Point, float]:
        """Out of the deepest inflation along its normal, slowly; aside where that leads into another, else not at all."""
        deepest = view.scene[int(np.argmax(view.scene[:, 5]))]
        direction = towards((deepest[0], deepest[1]), view.own_m)
        direction = direction if direction != (0.0, 0.0) else (math.cos(view.course_rad), math.sin(view.course_rad))
        speed = LEAVING_SHARE * self._limits.speed_max_m_s
        self._state["turn"] = 0.0
        outwards = math.atan2(direction[1], direction[0])
        others = np.ascontiguousarray(view.scene[view.scene[:, 5] <= 0.0])
        reach_m = speed * (self._parameters.reaction_s + self._period_s) + speed**2 / (2.0 * float(self._motion[0]["braking"]))
        for aside in LEAVING_ASIDE_RAD:
            n, e = math.cos(outwards + aside), math.sin(outwards + aside)
            if not is_barred(others, *view.own_m, view.own_m[0] + reach_m * n, view.own_m[1] + reach_m * e):
                return (speed * n, speed * e), wrap_pi(outwards + aside)
        return (0.0, 0.0), view.course_rad

    def _look_around(self, view: View) -> tuple[Point, float]:
        """Standing without any way to go: turn to the widest free gap."""
        gap = float(free_gap_rad(view.scene, *view.own_m, float(self._limits.speed_max_m_s)))
        error = 0.0 if math.isnan(gap) else wrap_pi(gap - view.course_rad)
        step = self._limits.yaw_rate_max_rad_s * self._period_s
        self._state["turn"] = 0.0
        return (0.0, 0.0), wrap_pi(view.course_rad + max(-step, min(step, error)))

    def _decision(
        self, view: View, intent: Intent, rendezvous: Rendezvous | None, velocity: Point, yaw_rad: float, guided: Point | None
    ) -> Decision:
        before, self._phase = self._phase, intent.phase
        known = rendezvous is not None
        distance = math.dist(view.own_m, intent.goal_m)
        guide = self._guide
        flags = self._status.flags(rendezvous, goal_is_covered=guide.goal_is_covered, is_blocked=guide.is_blocked)
        phase_news = REASONS[intent.phase] if intent.phase != before else ""
        diagnostics: dict[str, object] = {
            "stage": intent.phase,
            "target_distance_m": view.distance_m if known else None,
            "eta_s": distance / self._limits.speed_max_m_s if known else None,
            "clearance_m": view.clearance_m,
            "encircled": self._judge.surrounded,
            "captured": self._judge.captured,
            "guidance": self._guide.why if guided is not None else "",
            "slot": None if rendezvous is None else rendezvous.slot,
            "slots": None if rendezvous is None else rendezvous.slots,
            "base_point": None if rendezvous is None else [rendezvous.north_m, rendezvous.east_m],
            "plan": None if rendezvous is None else ("alone" if self._hunt is not None else "leader"),
            "flags": flags,
            "admissible": len(self._verdicts) - int(self._state[0]["collisions"]),
        }
        return Decision(
            velocity_ned_m_s=np.array((*velocity, 0.0)),
            acceleration_ned_m_s2=None,
            yaw_rad=yaw_rad,
            mode=intent.phase,
            goal_ned_m=np.array((*intent.goal_m, 0.0)),
            reason="; ".join(filter(None, (phase_news, self._status.news(view.t_s, flags)))),
            diagnostics=diagnostics,
        )


REASONS = {
    "hold": "no target was seen yet",
    "search": "the target is no longer seen",
    "approach": "to the slot at the meeting point",
    "form": "the target is near the meeting point: to the slot around it",
    "enclose": "on the ring around the target",
}


def rendezvous_of(hunt: Hunt, name: str) -> Rendezvous:
    """The part of `name` in `hunt`."""
    place = hunt.places[name]
    return Rendezvous(*hunt.base_m, hunt.heading_rad, hunt.radius_m, hunt.slots, place.slot, hunt.closing, hunt.reachable)


def hunters_of(observation: Observation, stale_s: float, speed_max_m_s: float) -> tuple[Hunter, ...]:
    """Who takes part, as the observation tells: oneself first, then the teammates in the order of names."""
    fresh = sorted((member for member in observation.team if member.age_s <= stale_s), key=lambda member: member.name)
    states = [(ALONE, observation.own), *((member.name, member.state) for member in fresh)]
    hunters = []
    for name, state in states:
        north, east, _ = state.position_ned_m.tolist()
        v_north, v_east, _ = state.velocity_ned_m_s.tolist()
        hunters.append(Hunter(name, (north, east), state.yaw_rad, math.hypot(v_north, v_east), speed_max_m_s))
    return tuple(hunters)


def motion_record(parameters: HuntingParameters, limits: Limits) -> np.ndarray:
    """What the window needs of the vehicle (1,)."""
    motion = np.zeros(1, MOTION)
    horizon_s = parameters.horizon_s or min(4.0, max(1.5, limits.speed_max_m_s / limits.acceleration_max_m_s2))
    horizon_s = max(horizon_s, 2.0 * parameters.control_period_s)
    motion["speed_max"], motion["acceleration"] = limits.speed_max_m_s, limits.acceleration_max_m_s2
    motion["braking"] = parameters.braking_share * limits.acceleration_max_m_s2
    motion["sideways"], motion["turn_max"] = limits.acceleration_max_m_s2, limits.yaw_rate_max_rad_s
    motion["turn_acceleration"] = limits.yaw_acceleration_max_rad_s2
    motion["period_s"], motion["reaction_s"] = parameters.control_period_s, parameters.reaction_s
    motion["horizon_s"] = horizon_s
    motion["window_s"] = horizon_s
    motion["heading_weight"] = parameters.weight_heading
    motion["clearance_weight"] = parameters.weight_clearance
    motion["velocity_weight"] = parameters.weight_velocity
    motion["beyond"] = 1.0 if parameters.free_way_beyond_horizon else 0.0
    return motion

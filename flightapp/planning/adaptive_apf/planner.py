"""The strategy `adaptive-apf`: one velocity a control period from the field of forces around the vehicle, in three dimensions.

No map and no horizon: it can be trapped, and says so. Nothing depends on the mission frame's origin or directions, except that
head-on encounters are passed on the same hand by all.
"""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.angles import wrap_pi
from flightapp.core.types import Array, Decision, Limits, Observation
from flightapp.planning.adaptive_apf.escape import (
    COUNT,
    FORCE_SHARE,
    PAST,
    PUSH_N,
    TRAP_SIZE,
    TRIED,
    TRIES,
    UNTIL,
    barred_by_m,
    begin_escape,
    escape_direction,
    forget,
    is_trapped,
)
from flightapp.planning.adaptive_apf.field import COURSE, FIELD_SIZE, FORCE, GAIN, NEAREST, PUSH, REACH_OUT, RISK, sum_forces
from flightapp.planning.adaptive_apf.goal import Goal, goal_of, numbers, out_of_bodies
from flightapp.planning.adaptive_apf.parameters import AdaptiveApfParameters
from flightapp.planning.adaptive_apf.setpoint import filter_velocity, limit_change, limit_turn
from flightapp.planning.adaptive_apf.surroundings import Surroundings
from flightapp.planning.api import BLOCKED, STATE_LOST, STUCK
from flightapp.planning.encirclement.capture_watch import CaptureWatch
from flightapp.space.bodies import LENGTH
from flightapp.space.distance import nearest_bodies

PURSUE, ESCAPE, LEAVE, SEARCH, HOLD, DONE = "pursue", "escape", "leave", "search", "hold", "done"
"""The modes that a decision carries, beside those of `NEEDS_HELP`."""
NEAREST_MAX = 32
BLIND_HOLD_S, LOST_S = 0.2, 1.0
"""Without a finite own state the last command is held this long; after LOST_S the state counts as lost."""
GAP_S = 0.3
"""After a longer time between observations the last command is no longer where changes begin."""
LEAVING_SHARE = 0.3
GAINING_SHARE = 0.7
"""A command slower than this share of what is wanted, in its direction, is a vehicle that gains speed: no trap is looked for."""
FACING_M_S = 0.5


class AdaptiveApfPlanner:
    """One pursuer. The only random numbers are those of the escape, drawn from its seed."""

    def __init__(self, *, limits: Limits, parameters: AdaptiveApfParameters, seed: int) -> None:
        self._limits, self._parameters, self._seed = limits, parameters, seed
        self._gains = parameters.gains(limits)
        self._flat_gains = self._gains._replace(vertical_weight=0.0)
        self._surroundings = Surroundings(parameters, limits)
        self._which = np.zeros(NEAREST_MAX, dtype=np.int64)
        self._gaps, self._shares = np.zeros((NEAREST_MAX, 4)), np.zeros(NEAREST_MAX)
        self._field = np.zeros(FIELD_SIZE)
        self.reset()

    def reset(self, seed: int | None = None) -> None:
        """Forget everything; `seed`: draw from another one from now on."""
        self._seed = self._seed if seed is None else seed
        self._random = np.random.default_rng(self._seed)
        self._surroundings.reset()
        self._watch = CaptureWatch(self._parameters.capture)
        self._trap, self._past = np.zeros(TRAP_SIZE), np.zeros((PAST, 3))
        self._command = np.zeros(3)
        self._start: Array | None = None
        self._seen: Goal | None = None
        self._t_s: float | None = None
        self._finite_s = -math.inf
        self._stuck_until_s = -math.inf
        self._gains_speed = False
        self._mode = ""
        self._last: Decision | None = None

    def step(self, observation: Observation) -> Decision:
        """One decision; see the class."""
        if self._last is not None and self._t_s is not None and observation.t_s <= self._t_s:
            return self._last
        own = observation.own
        dt_s = observation.dt_s if observation.dt_s > 0.0 else self._parameters.control_period_s
        fresh = self._t_s is None or observation.t_s - self._t_s > GAP_S
        self._t_s = observation.t_s
        if not (np.isfinite(own.position_ned_m).all() and np.isfinite(own.velocity_ned_m_s).all()):
            return self._blind(observation)
        self._finite_s = observation.t_s
        goal = goal_of(observation, self._parameters, self._limits, self._seen)
        self._seen = goal
        self._surroundings.look(observation, None if goal is None else goal.target_ned_m)
        if fresh:
            self._surroundings.forget_reaches()
        lag_s = self._parameters.response_lag_s
        place = own.position_ned_m + lag_s * own.velocity_ned_m_s
        blend = 1.0 if fresh else self._parameters.command_blend
        base = blend * own.velocity_ned_m_s + (1.0 - blend) * self._command
        return self._decide(observation, goal, place, base, dt_s)

    def _blind(self, observation: Observation) -> Decision:
        """Without an own state: the last command for a moment, then stand."""
        blind_s = observation.t_s - self._finite_s
        if blind_s > BLIND_HOLD_S:
            self._command = np.zeros(3)
        flags: dict[str, object] = {"state_lost_s": min(blind_s, 1e9)}
        yaw_rad = observation.own.yaw_rad if math.isfinite(observation.own.yaw_rad) else 0.0
        if blind_s > LOST_S:
            return self._decision(self._command, yaw_rad, STATE_LOST, None, f"no own state for {LOST_S:g} s", flags)
        return self._decision(self._command, yaw_rad, HOLD, None, "the own state is not finite", flags)

    def _decide(self, observation: Observation, goal: Goal | None, place: Array, base: Array, dt_s: float) -> Decision:
        around = self._surroundings
        flat = self._parameters.vertical == "hold" or not around.heights_known
        aim, moved, blocked = (place, False, False) if goal is None else self._reachable(goal, flat, place)
        if self._start is None:
            self._start = place.copy()
        count = nearest_bodies(around.bodies, *numbers(place), 0.0, self._parameters.reach_max_m, self._which, self._gaps)
        sum_forces(
            around.bodies, self._which, self._gaps, count, place, base, self._start, aim, around.tracks,
            self._flat_gains if flat else self._gains, observation.t_s, dt_s, self._field,
        )  # fmt: skip
        force, mode, reason = self._force(goal, aim, place, count, flat, observation.t_s, blocked=blocked)
        wanted = self._wanted(force, base, goal, mode, dt_s)
        if flat:
            wanted[2] = 0.0
        filtered = self._within_limits(wanted, base, count, dt_s, flat=flat)
        self._command = wanted
        if goal is not None and self._captured(observation, goal):
            mode, reason = DONE, "the capture rule is met"
        elif goal is not None and goal.age_s > self._parameters.target_stale_s and mode == PURSUE:
            mode, reason = SEARCH, f"the target was last seen {goal.age_s:.1f} s ago"
        yaw_rad = self._yaw_rad(observation, wanted, goal)
        told = {"captured": mode == DONE, **self._told(moved, filtered)}
        return self._decision(wanted, yaw_rad, mode, None if goal is None else aim, reason, told)

    def _reachable(self, goal: Goal, flat: bool, place: Array) -> tuple[Array, bool, bool]:
        """Where to fly to meet the goal, out of the bodies that it is in or too near to; whether it was moved, and whether it
        could not be. Where the meeting lies too deep in a body, to where the target is now.
        """
        kept_m = self._limits.body_radius_m + self._parameters.margin(self._limits)
        for aim in (goal.aim_ned_m, goal.target_ned_m):
            level = np.array((aim[0], aim[1], place[2])) if flat else aim
            outside, moved = out_of_bodies(self._surroundings.bodies, level, kept_m, self._parameters.goal_margin_max_m)
            if outside is not None:
                return np.array((outside[0], outside[1], place[2])) if flat else outside, moved, False
        return level, False, True

    def _force(
        self, goal: Goal | None, aim: Array, place: Array, count: int, flat: bool, t_s: float, *, blocked: bool
    ) -> tuple[Array, str, str]:
        """The force in all (3,), with the mode that it means and why."""
        field = self._field
        if count and self._gaps[0, 0] <= self._limits.body_radius_m:
            return self._gaps[0, 1:4] * self._parameters.full_attraction_m_s2, LEAVE, "the vehicle is inside an obstacle"
        repelled = field[PUSH : PUSH + 3].copy()
        if goal is None:
            return repelled, HOLD, "the target was never seen or is lost"
        if blocked:
            deep_m = self._parameters.goal_margin_max_m
            return repelled, BLOCKED, f"the target is in an obstacle, with no free place within {deep_m:g} m"
        if not count:
            forget(self._trap)  # held by somebody, not by bodies
        elif "B" in self._parameters.modules:
            bodies, radius_m = self._surroundings.bodies, self._limits.body_radius_m
            if t_s < self._stuck_until_s and barred_by_m(bodies, self._which, count, place, aim, radius_m) >= 0.0:
                return repelled, STUCK, f"trapped after {TRIES} escapes: a way around is needed"
            self._stuck_until_s = -math.inf
            escape = self._escape(aim, place, count, flat, t_s)
            if escape is not None:
                return field[FORCE : FORCE + 3] + escape, ESCAPE, "hardly any progress and the way is barred"
        return field[FORCE : FORCE + 3].copy(), PURSUE, "the target is known"

    def _escape(self, aim: Array, place: Array, count: int, flat: bool, t_s: float) -> Array | None:
        """The push (3,) of an escape that begins or lasts. After as many in vain as are tried, none for a while."""
        trap, radius_m = self._trap, self._limits.body_radius_m
        if not self._gains_speed and is_trapped(
            trap, self._past, self._surroundings.bodies, self._which, count, place, aim, radius_m, self._limits.speed_max_m_s,
            self._parameters.capture.radius_m, t_s,
        ):  # fmt: skip
            if trap[TRIED] >= TRIES:
                self._stuck_until_s = t_s + self._parameters.stuck_s
                trap[TRIED] = trap[COUNT] = 0.0
                return None
            self._begin_escape(aim - place, flat, t_s)
        if t_s >= trap[UNTIL]:
            return None
        attraction = self._parameters.attraction_1_s2 * float(np.linalg.norm(aim - place))
        size = FORCE_SHARE * min(self._parameters.full_attraction_m_s2, attraction)
        push: Array = size * trap[PUSH_N : PUSH_N + 3]
        return push

    def _begin_escape(self, ahead: Array, flat: bool, t_s: float) -> None:
        field, trap = self._field, self._trap
        draw = self._random.normal(size=3)
        if flat:
            draw[2] = 0.0
        spread = 0.5 * 1.5 ** trap[TRIED]
        push = escape_direction(*numbers(field[PUSH : PUSH + 3]), *numbers(ahead), *numbers(draw), spread)
        nearest_m = float(self._surroundings.bodies[self._which[0], LENGTH])
        begin_escape(trap, *push, (nearest_m + field[REACH_OUT]) / self._limits.speed_max_m_s, t_s)

    def _wanted(self, force: Array, base: Array, goal: Goal | None, mode: str, dt_s: float) -> Array:
        """Velocity (3,) that the force asks for, without the vehicle's limits of change."""
        speed_max = self._limits.speed_max_m_s
        size = float(np.linalg.norm(force))
        if self._parameters.law == "double-integrator" and mode != LEAVE:
            velocity = np.zeros(3) if goal is None or mode == BLOCKED else goal.velocity_ned_m_s
            damping_1_s = self._parameters.damping_1_s or self._parameters.full_attraction_m_s2 / speed_max
            return base + dt_s * (force + damping_1_s * (velocity - base))
        if size < 1e-9:
            return np.zeros(3)
        speed = speed_max * (1.0 + float(self._field[GAIN]))
        share = min(1.0, size / self._parameters.full_attraction_m_s2)
        if mode == LEAVE:
            return force * (LEAVING_SHARE * speed_max / size)
        if goal is None or mode in (STUCK, BLOCKED):
            return force * (LEAVING_SHARE * speed_max * share / size)
        if not self._parameters.holds and goal.age_s <= self._parameters.target_stale_s:
            share = 1.0  # contact ends it: nothing is gained by arriving slowly
            return force * (min(speed, speed_max) / size)
        wanted = goal.velocity_ned_m_s + force * (min(speed * share, self._parameters.slot_gain_per_s * size) / size)
        total = float(np.linalg.norm(wanted))
        return wanted * min(1.0, speed_max / total) if total > 0.0 else wanted

    def _within_limits(self, wanted: Array, base: Array, count: int, dt_s: float, *, flat: bool) -> bool:
        """Change `wanted` (3,) to what the vehicle can do from `base` and what is safe; whether the safety filter changed it."""
        limits = self._limits
        change_max = limits.acceleration_max_m_s2 * dt_s
        asked_m_s, ahead = float(np.linalg.norm(wanted)), float(wanted @ base)
        limit_turn(wanted, base, limits.yaw_rate_max_rad_s * dt_s)
        limit_change(wanted, base, change_max)
        self._gains_speed = ahead > 0.0 and float(np.linalg.norm(wanted)) < GAINING_SHARE * asked_m_s
        filtered, level = False, float(wanted[2])
        if self._parameters.filter_form > 0.0:
            kept_m = limits.body_radius_m + self._parameters.margin(limits)
            filtered = filter_velocity(
                self._surroundings.bodies, self._which, self._gaps, count, wanted, kept_m, self._parameters.filter_form,
                self._parameters.barrier_1_s, self._parameters.braking_share * limits.acceleration_max_m_s2,
                self._parameters.reaction_s, self._shares,
            )  # fmt: skip
            if flat:
                wanted[2] = level
            limit_change(wanted, base, change_max)
        climb = max(-limits.climb_rate_max_m_s, min(limits.sink_rate_max_m_s, float(wanted[2])))
        wanted[2] = climb
        speed = float(np.linalg.norm(wanted))
        if speed > limits.speed_max_m_s:
            wanted *= limits.speed_max_m_s / speed
        return bool(filtered)

    def _captured(self, observation: Observation, goal: Goal) -> bool:
        heard = [member for member in observation.team if member.age_s <= self._parameters.team_stale_s]
        places = [observation.own.position_ned_m[:2], *(member.state.position_ned_m[:2] for member in heard)]
        team = np.array(places)
        evader = float(goal.target_ned_m[0]), float(goal.target_ned_m[1])
        distances = np.hypot(team[:, 0] - evader[0], team[:, 1] - evader[1])
        return self._watch.captured(observation.t_s, team, distances, evader, goal.age_s <= self._parameters.target_stale_s)

    def _yaw_rad(self, observation: Observation, velocity: Array, goal: Goal | None) -> float:
        """Nose along the way; slow, towards the target."""
        if math.hypot(velocity[0], velocity[1]) > FACING_M_S:
            return math.atan2(velocity[1], velocity[0])
        if goal is None:
            return observation.own.yaw_rad
        to = goal.target_ned_m - observation.own.position_ned_m
        return math.atan2(to[1], to[0]) if math.hypot(to[0], to[1]) > 1e-9 else observation.own.yaw_rad

    def _told(self, goal_projected: bool, filtered: bool) -> dict[str, object]:
        field = self._field
        nearest = float(field[NEAREST])
        return {
            "clearance_m": nearest if math.isfinite(nearest) else None,
            "risk": float(field[RISK]),
            "collision_course": bool(field[COURSE]),
            "speed_gain": float(field[GAIN]),
            "goal_projected": goal_projected,
            "filtered": filtered,
            "dropped_discs": self._surroundings.dropped,
        }

    def _decision(
        self, velocity: Array, yaw_rad: float, mode: str, goal: Array | None, reason: str, told: dict[str, object]
    ) -> Decision:
        changed, self._mode = mode != self._mode, mode
        self._last = Decision(
            velocity_ned_m_s=velocity.copy(),
            acceleration_ned_m_s2=None,
            yaw_rad=wrap_pi(yaw_rad),
            mode=mode,
            goal_ned_m=None if goal is None else goal.copy(),
            reason=reason if changed else "",
            diagnostics=told,
        )
        return self._last

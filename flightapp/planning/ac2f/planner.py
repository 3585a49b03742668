"""AC2F: the state machine coarse / fine / tracking around one pursuer's intent and its avoidance."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flightapp.core.angles import wrap_pi
from flightapp.core.types import Array, Decision, Limits, Observation
from flightapp.planning.ac2f.dynamic_window import Choice, DynamicWindow, Motion, command_of
from flightapp.planning.ac2f.edge import NO_EDGE, Edge
from flightapp.planning.ac2f.history import History
from flightapp.planning.ac2f.looking import nose_bearing, seen_velocity
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.potential_field import FieldParameters, deflected, safe_velocity
from flightapp.planning.ac2f.pursuit import Intent, Pursuit
from flightapp.planning.ac2f.scene import Mover, build_scene, depth_m, scene_clearance_m
from flightapp.planning.ac2f.stage import Facts, Stage, next_stage
from flightapp.planning.ac2f.surroundings import Target, Trail, target_now, teammate_now
from flightapp.planning.capture import Dwell, closest_approach_between_m, encircled
from flightapp.planning.plane import Point, crosses, limited, planar, towards, unit

AIM_M = 3.0
STANDING_M_S = 0.3
SEARCH_TURN_RAD = 0.5
MEMORY_RELEASE_M = 3.0
LEAVE_FIRST_M = 0.1  # deeper than this inside a margin, leaving it comes before everything


@dataclass(frozen=True, slots=True)
class _View:
    """One observation, digested; `ahead` is where the lag of the velocity loop puts the vehicle."""

    t_s: float
    own: Point
    base: Point
    ahead: Point
    team: tuple[tuple[Point, Point], ...]
    team_complete: bool
    target: Target | None
    obstacles: Array
    scene: Array


@dataclass(frozen=True, slots=True)
class _Action:
    """What the stage decided: velocity command, where the nose points, the goal, and what is worth recording."""

    velocity: Point
    yaw_rad: float
    goal: Point | None
    notes: Mapping[str, object]


class Ac2fPlanner:
    """The strategy `ac2f` (Zhang et al. 2026). Nothing in it is random."""

    def __init__(self, *, limits: Limits, parameters: Ac2fParameters) -> None:
        self._limits = limits
        self._parameters = parameters
        self._pursuit = Pursuit(parameters, limits)
        self._window = DynamicWindow(parameters, limits)
        self._inflation_m = max(parameters.rejection_radius_m, limits.body_radius_m + limits.safety_margin_m)
        self._field = FieldParameters(
            parameters.field_gain_m2,
            parameters.field_influence_m,
            parameters.field_repulsion_max,
            limits.acceleration_max_m_s2 * parameters.braking_share,
            parameters.reaction_s,
        )
        self.reset()

    def reset(self, seed: int | None = None) -> None:
        """Forget everything."""
        del seed
        parameters = self._parameters
        self._oscillation_samples = max(2, round(parameters.oscillation_window_s / parameters.control_period_s))
        self._history = History(max(parameters.history_samples, self._oscillation_samples), parameters.control_period_s)
        self._trail = Trail(parameters.vehicle_trail_s, parameters.control_period_s)
        self._dwell = Dwell(parameters.capture.dwell_s)
        self._stage = Stage.HOLD
        self._stage_since_s = 0.0
        self._trapped_at: Point | None = None
        self._trapped_in = False
        self._paused = False
        self._boundary_lost = False
        self._command: Point | None = None
        self._turn_rad_s = 0.0
        self._yaw_rad: float | None = None
        self._before: tuple[Point, Point] | None = None
        self._last_seen: tuple[float, Point] | None = None
        self._edge = NO_EDGE

    def step(self, observation: Observation) -> Decision:
        """One decision; see the class."""
        if self._edge.boundary is not observation.boundary:
            self._edge = Edge.of(observation.boundary)
        view = self._view(observation)
        closest_m = self._closest_m(view)
        surrounded = self._encircled(view, closest_m)
        self._dwell.update(view.t_s, surrounded)
        reason = self._change_stage(view, closest_m)
        action, intent = self._act(view, observation)
        self._remember(view, action)
        return self._decision(view, action, intent, surrounded, reason)

    # what is known

    def _view(self, observation: Observation) -> _View:
        parameters = self._parameters
        own, velocity = planar(observation.own.position_ned_m), planar(observation.own.velocity_ned_m_s)
        last = velocity if self._command is None else self._command
        blend = parameters.command_blend
        base = (last[0] + blend * (velocity[0] - last[0]), last[1] + blend * (velocity[1] - last[1]))
        lag = parameters.response_lag_s
        ahead = (own[0] + lag * (velocity[0] - base[0]), own[1] + lag * (velocity[1] - base[1]))
        fresh = [member for member in observation.team if member.age_s <= parameters.team_stale_s]
        team = tuple(teammate_now(member) for member in fresh)
        stale = [teammate_now(member)[0] for member in observation.team if member.age_s > parameters.team_stale_s]
        target = None if observation.target is None else target_now(observation.target, observation.t_s)
        others = [*(place for place, _ in team), *stale, *(() if target is None else (target.position,))]
        movers = self._movers(team, target)
        scene = build_scene(
            observation.obstacles.discs,
            max(0.0, observation.t_s - observation.obstacles.t_s),
            own,
            self._inflation_m,
            parameters.obstacle_range_m,
            movers,
            self._trail.places(observation.t_s, others),
            parameters.vehicle_disc_m,
            parameters.vehicle_radius_max_m,
        )
        moving = sum(math.dist(mover.position, own) - mover.distance_m <= parameters.obstacle_range_m for mover in movers)
        obstacles = scene[: len(scene) - moving]
        return _View(observation.t_s, own, base, ahead, team, len(fresh) == len(observation.team), target, obstacles, scene)

    def _movers(self, team: tuple[tuple[Point, Point], ...], target: Target | None) -> list[Mover]:
        separation = self._pursuit.team_distance_m(len(team) + 1)
        movers = [Mover(position, velocity, separation) for position, velocity in team]
        keep_out = self._pursuit.evader_distance_m
        if target is not None and keep_out > 0.0 and target.age_s <= self._parameters.target_stale_s:
            movers.append(Mover(target.position, target.velocity, keep_out))
        return movers

    def _closest_m(self, view: _View) -> float:
        """Closest approach to the evader since the last step; keeps track of the evader and of its crossing."""
        if view.target is None:
            self._before = None
            return math.inf
        evader = view.target.position
        closest = math.dist(view.own, evader)
        if self._before is not None:
            closest = closest_approach_between_m(self._before[0], view.own, self._before[1], evader)
            self._boundary_lost = self._boundary_lost or crosses(self._before[1], evader, self._edge.sides)
        self._before = (view.own, evader)
        return closest

    def _encircled(self, view: _View, closest_m: float) -> bool:
        rule = self._parameters.capture
        if view.target is None or view.target.age_s > self._parameters.target_stale_s:
            return False
        if rule.mode == "first":
            return closest_m <= rule.radius_m
        return view.team_complete and encircled(view.target.position, [view.own, *(place for place, _ in view.team)], rule)

    # which stage

    def _change_stage(self, view: _View, closest_m: float) -> str:
        parameters = self._parameters
        variance = self._history.variance_m2(self._oscillation_samples)
        since_s = view.t_s - self._stage_since_s
        facts = Facts(
            target_age_s=self._target_age_s(view),
            distance_m=math.inf if view.target is None else math.dist(view.own, view.target.position),
            closest_m=closest_m,
            oscillating=variance is not None and variance < parameters.oscillation_variance_m2,
            captured=self._dwell.done,
            trapped_in=self._trapped_in,
            fine_s=since_s,
            coarse_s=since_s,
            paused=self._paused,
        )
        stage, reason = next_stage(self._stage, facts, parameters)
        if stage is not self._stage:
            self._enter(stage, view, facts)
        if self._trapped_at is not None and math.dist(view.own, self._trapped_at) > MEMORY_RELEASE_M:
            self._trapped_at = None
        return reason

    def _enter(self, stage: Stage, view: _View, facts: Facts) -> None:
        trigger_m = self._parameters.fine_trigger_m
        self._trapped_in = stage is Stage.FINE and self._stage is Stage.COARSE and facts.oscillating
        if self._trapped_in:
            self._trapped_at = view.own
        self._paused = self._stage is Stage.FINE and stage is Stage.COARSE and facts.distance_m < trigger_m
        if self._stage is Stage.FINE:
            self._turn_rad_s = 0.0
        self._stage = stage
        self._stage_since_s = view.t_s

    def _target_age_s(self, view: _View) -> float | None:
        if view.target is not None:
            if view.target.age_s <= self._parameters.target_stale_s or self._last_seen is None:
                self._last_seen = (view.t_s - view.target.age_s, view.target.position)
            return view.target.age_s
        return None if self._last_seen is None else view.t_s - self._last_seen[0]

    # what to do

    def _act(self, view: _View, observation: Observation) -> tuple[_Action, Intent | None]:
        if view.target is None or self._stage in (Stage.HOLD, Stage.SEARCH):
            if self._stage is Stage.HOLD or self._last_seen is None:
                return self._hold(view), None
            return self._search(view, observation, self._last_seen[1]), None
        intent = self._pursuit.intent(
            view.own,
            [place for place, _ in view.team],
            [member.eta_s for member in observation.team if member.eta_s is not None],
            view.target,
            view.obstacles,
            self._edge.rows,
            closed=observation.boundary.closed,
            boundary_lost=self._boundary_lost,
        )
        if self._stage is Stage.FINE and depth_m(view.scene) < LEAVE_FIRST_M:
            return self._fine(view, view.target, intent, observation), intent
        return self._reactive(view, view.target, intent.goal, intent.velocity, observation), intent

    def _hold(self, view: _View) -> _Action:
        velocity = safe_velocity(view.scene, view.ahead, (0.0, 0.0), view.base, self._limits.speed_max_m_s, self._field)
        return _Action(self._slewed(view, velocity), self._nose_rad, None, {})

    def _search(self, view: _View, observation: Observation, place: Point) -> _Action:
        """Fly to the last predicted point; there, turn to look around."""
        action = self._reactive(view, None, place, self._pursuit.velocity_to(view.own, place), observation)
        if math.hypot(*action.velocity) > STANDING_M_S:
            return action
        return _Action(action.velocity, wrap_pi(observation.own.yaw_rad + SEARCH_TURN_RAD), place, action.notes)

    def _reactive(self, view: _View, target: Target | None, goal: Point, wish: Point, observation: Observation) -> _Action:
        """Coarse and tracking: the wish, deflected by obstacles and made safe."""
        parameters = self._parameters
        turned = deflected(view.obstacles, view.own, wish, self._field)
        chosen = safe_velocity(view.scene, view.ahead, turned, view.base, self._limits.speed_max_m_s, self._field)
        seen = seen_velocity(chosen, observation.obstacles.unseen, parameters.unseen_speed_m_s)
        watched = target.position if target is not None and self._near(view, target) else None
        yaw = nose_bearing(chosen, parameters.face_evader_speed_m_s, view.own, watched, self._nose_rad)
        return _Action(self._slewed(view, seen), yaw, goal, {})

    def _fine(self, view: _View, target: Target, intent: Intent, observation: Observation) -> _Action:
        parameters = self._parameters
        wish = intent.velocity
        direction = unit(wish) if wish != (0.0, 0.0) else towards(view.own, intent.goal)
        aim = (view.own[0] + AIM_M * direction[0], view.own[1] + AIM_M * direction[1])
        near = math.dist(view.own, target.position) < parameters.fine_trigger_m
        motion = self._motion(view, observation, direction, near)
        course = (math.cos(motion.course_rad), math.sin(motion.course_rad))
        speed_limit = math.hypot(*wish)
        along = (course[0] * speed_limit, course[1] * speed_limit)
        speed_limit = math.hypot(*seen_velocity(along, observation.obstacles.unseen, parameters.unseen_speed_m_s))
        choice = self._window.choose(
            motion,
            aim,
            speed_limit,
            view.scene,
            self._history.points[-parameters.history_samples :],
            near=near,
            memory_weight=0.0 if self._trapped_at is None else parameters.memory_weight,
        )
        self._turn_rad_s = choice.turn_rad_s
        velocity = command_of(motion, choice, parameters.control_period_s)
        return _Action(velocity, self._fine_yaw(view, target, choice, velocity, direction), intent.goal, _notes(choice))

    def _fine_yaw(self, view: _View, target: Target, choice: Choice, velocity: Point, direction: Point) -> float:
        if choice.look_rad is not None:
            return choice.look_rad
        watched = target.position if self._near(view, target) else (view.own[0] + direction[0], view.own[1] + direction[1])
        return nose_bearing(velocity, self._parameters.face_evader_speed_m_s, view.own, watched, self._nose_rad)

    def _motion(self, view: _View, observation: Observation, direction: Point, near: bool) -> Motion:
        """The unicycle state: course of the blended command; standing, the nose - or any course near the evader."""
        speed = math.hypot(*view.base)
        course = math.atan2(view.base[1], view.base[0])
        if speed < STANDING_M_S:
            course = math.atan2(direction[1], direction[0]) if near else observation.own.yaw_rad
        return Motion(view.ahead, course, min(speed, self._limits.speed_max_m_s), self._turn_rad_s)

    def _near(self, view: _View, target: Target) -> bool:
        return math.dist(view.own, target.position) <= self._parameters.slot_range_m

    def _slewed(self, view: _View, wanted: Point) -> Point:
        """The velocity of the window that is nearest to `wanted`."""
        reach = self._limits.acceleration_max_m_s2 * self._parameters.control_period_s
        change = limited((wanted[0] - view.base[0], wanted[1] - view.base[1]), reach)
        return limited((view.base[0] + change[0], view.base[1] + change[1]), self._limits.speed_max_m_s)

    @property
    def _nose_rad(self) -> float:
        return 0.0 if self._yaw_rad is None else self._yaw_rad

    # what stays

    def _remember(self, view: _View, action: _Action) -> None:
        self._command = action.velocity
        self._yaw_rad = wrap_pi(action.yaw_rad)
        self._history.add(view.t_s, view.own)
        if self._stage in (Stage.TRACKING, Stage.HOLD, Stage.SEARCH):
            self._history.clear()

    def _decision(self, view: _View, action: _Action, intent: Intent | None, surrounded: bool, reason: str) -> Decision:
        goal = None if action.goal is None else np.array((*action.goal, 0.0))
        return Decision(
            velocity_ned_m_s=np.array((*action.velocity, 0.0)),
            acceleration_ned_m_s2=None,
            yaw_rad=self._nose_rad,
            mode=str(self._stage),
            goal_ned_m=goal,
            reason=reason,
            diagnostics={**self._diagnostics(view, intent, surrounded), **action.notes},
        )

    def _diagnostics(self, view: _View, intent: Intent | None, surrounded: bool) -> dict[str, object]:
        saturation = self._parameters.obstacle_range_m
        known: dict[str, object] = {
            "stage": str(self._stage),
            "target_distance_m": None if view.target is None else math.dist(view.own, view.target.position),
            "eta_s": None,
            "contested": None,
            "game_point": None,
            "circles": [],
            "clearance_m": scene_clearance_m(view.scene, *view.own, saturation),
            "encircled": surrounded,
            "captured": self._dwell.done,
            "memory_weight": 0.0 if self._trapped_at is None else self._parameters.memory_weight,
        }
        if intent is not None:
            game = intent.game
            known["eta_s"] = intent.eta_s
            known["contested"] = game.contested and not self._boundary_lost
            known["game_point"] = list(game.point)
            known["circles"] = game.circles()
        return known


def _notes(choice: Choice) -> dict[str, object]:
    """What the dynamic window found: the best arc's scores, or why there is none."""
    if choice.best is None:
        return {"no_admissible": True, "tally": dict(choice.tally)}
    return {"best": dict(choice.best)}

"""The control loop: once for every processed depth frame, and at a fixed rate when none comes.

observe -> plan -> supervise -> send -> record, in that order, in one place. It never waits for anything else than the
next frame, so the setpoint stream can starve only if this process hangs; then the deadman acts.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from enum import Enum
from typing import Protocol

import numpy as np
import psutil

from flightapp.core.clearance import NO_OBSTACLE_M, clearance_in_space_m
from flightapp.core.types import Decision, Observation, ObstacleSet, Setpoint, TargetTrack, VehicleState
from flightapp.fleet.messages.command import Command
from flightapp.planning.api import NEEDS_HELP
from flightapp.runtime.coordination import Coordination
from flightapp.runtime.disc_sharing import DiscSharing
from flightapp.runtime.fleet_time import FleetTime
from flightapp.runtime.heartbeat import ACTIVE, CLIMBING, IDLE, LEFT
from flightapp.runtime.hover import Hover, wish_of
from flightapp.runtime.leadership import Leadership
from flightapp.runtime.perception_thread import PerceptionThread
from flightapp.runtime.rooms import Rooms
from flightapp.runtime.search_record import SearchRecord
from flightapp.runtime.target_fusion import TargetFusion
from flightapp.runtime.teamwork import Teamwork
from flightapp.safety.api import Demand, SafetyContext
from flightapp.safety.feed_forward import with_feed_forward
from flightapp.vehicle.autopilot import Motion, Status, vouches_for_position
from flightapp.vehicle.gap_meter import GapMeter

STATUS_PERIOD_S = 1.0
TEAM_PERIOD_S = 0.1
MOTION_EXTRAPOLATION_MAX_S = 0.3
LATENESS_KEPT = 10_000
DETOUR = "way-out"
"""The mode that others hear of, and operators see, while a planned way out is flown."""
CLIMBING_PHASES = ("arm", "takeoff")
CLIMBING_MODES = ("TAKEOFF", "HOLD")


class Guidance(Enum):
    """Where setpoints come from."""

    NONE = "none"
    """No setpoints: the autopilot flies by itself, or stands."""
    HOVER = "hover"
    """Brake, then stay."""
    PLANNER = "planner"
    """The mission's strategy decides."""
    WAY = "way"
    """A planned way is followed."""


class Follower(Protocol):
    """What flies a planned way."""

    arrived: bool
    failure: str
    """Why the vehicle does not get there; empty as long as it may."""

    def pause(self) -> None: ...

    def setpoint(self, own: VehicleState, now_s: float, yaw_rad: float) -> Setpoint: ...


class ControlLoop:
    """Owns the tick; the executive sets `guidance` and `phase`, everything else is read."""

    def __init__(self, rooms: Rooms, on_command: Callable[[Command], tuple[bool, str]]) -> None:
        self._rooms = rooms
        self._on_command = on_command
        self._teamwork = Teamwork(rooms)
        self._target_fusion = TargetFusion(rooms, self._teamwork)
        self._disc_sharing = DiscSharing(rooms, self._teamwork)
        self._fleet_time = FleetTime(rooms)
        self._search_record = SearchRecord(rooms.planner, rooms.journal)
        self.leadership = Leadership(rooms)
        self.coordination = Coordination(rooms, self._teamwork, self.leadership)
        self._hover = Hover(
            rooms.mission.height_of(rooms.vehicle),
            rooms.limits.climb_rate_max_m_s,
            rooms.profile.control.altitude_gain_1_s,
            rooms.limits.sink_rate_max_m_s,
        )
        self.perception: PerceptionThread | None = None
        self.guidance = Guidance.NONE
        self.phase = "preflight"
        self.outcome: str | None = None
        self.decision: Decision | None = None
        self.target: TargetTrack | None = None
        self.planner_failure: str | None = None
        self.decision_latency_s = 0.0
        self.decision_is_finite = True
        self.failure: str | None = None
        self.setpoints_sent = 0
        self.ticks = 0
        self.in_offboard = False
        """Set once OFFBOARD was reported; setpoints end in the very tick that sees another mode."""
        self.in_own_mode: Callable[[], bool] = lambda: True
        """The executive's answer, before every setpoint, to whether the reported mode is one that it asked for."""
        self.held = False
        """True while the failsafe's HOLD replaces the planner."""
        self.demand: Demand | None = None
        """What the supervisor asks of the executive since its last check."""
        self.lateness_s: deque[float] = deque(maxlen=LATENESS_KEPT)
        """Of the last ticks: from when each was due to its start."""
        self._wake = asyncio.Event()
        self._woken_s: float | None = None
        self._loop = asyncio.get_running_loop()
        self._yaw_rad = 0.0
        self._previous: Setpoint | None = None
        self._way: Follower | None = None
        self._way_yields = False
        self._detour: Follower | None = None
        self.is_detoured = False
        """True while the planner is asked and not flown, because a detour is."""
        self._last_tick_s: float | None = None
        self._last_frame: int | None = None
        self._camera_silent = False
        self._publish_due_s = -math.inf
        self._team_recorded_s = -math.inf
        self._status_recorded_s = -math.inf
        self._status_seen: tuple[str, bool, str, bool] | None = None
        self._lateness_max_s = 0.0
        self._gaps = GapMeter()
        self._obstacles = ObstacleSet(0.0, np.zeros((0, 7)), np.array([[-math.pi, math.pi]]))
        self._clearance_m: float | None = None
        self._guards: tuple[str, ...] = ()
        self._process = psutil.Process()
        self._process.cpu_percent()

    @property
    def is_hovering(self) -> bool:
        """True once a hover has come to rest."""
        return self.guidance is Guidance.HOVER and self._hover.at_rest

    def wake_from_thread(self) -> None:
        """Called by the perception thread when a frame is done."""
        if self._woken_s is None:
            self._woken_s = self._rooms.clock.now_s()
        self._loop.call_soon_threadsafe(self._wake.set)

    @property
    def is_standing(self) -> bool:
        """True once the vehicle has come to rest where something else than the planner holds it."""
        return self._hover.at_rest

    def hover_here(self, *, at_mission_height: bool = False) -> None:
        """From now on brake, then stay where the vehicle came to rest: after a planned way at the present height, if not told."""
        motion = self._rooms.autopilot.motion()
        self._yaw_rad = self._yaw_rad if motion is None else motion.state.yaw_rad
        self._hover.restart()
        if at_mission_height:
            self._hover.keep_mission_height()
        self.end_detour()
        self.guidance = Guidance.HOVER

    def follow(self, way: Follower, *, yields: bool = False) -> None:
        """From now on fly a planned way. yields: the failsafe's HOLD replaces it, as it does the planner."""
        self._way, self._way_yields = way, yields
        self.guidance = Guidance.WAY

    def detour(self, way: Follower | None) -> None:
        """From now on fly this in place of what the planner decides, which is asked all the same; None: stand."""
        if way is None:
            self._hover.restart()
        self._detour, self.is_detoured = way, True

    def end_detour(self) -> None:
        """The planner flies again."""
        self._detour, self.is_detoured = None, False

    @property
    def obstacles(self) -> ObstacleSet:
        """What is seen, or known to a vehicle without a camera."""
        return self._obstacles

    async def run(self) -> None:
        """Tick until cancelled."""
        asking = asyncio.create_task(self._fleet_time.ask())
        try:
            await self._run()
        finally:
            asking.cancel()

    async def _run(self) -> None:
        period_s = 1.0 / self._rooms.profile.control.rate_min_hz
        deadline_s = self._rooms.clock.now_s() + period_s
        while True:
            left_s = deadline_s - self._rooms.clock.now_s()
            if left_s > 0.0:
                with contextlib.suppress(TimeoutError):
                    async with asyncio.timeout(left_s):
                        await self._wake.wait()
            else:
                await asyncio.sleep(0)
            now_s = self._rooms.clock.now_s()
            self._note_lateness(now_s, deadline_s)
            self._wake.clear()
            deadline_s = now_s + period_s
            try:
                self.tick(now_s)
            except Exception as error:  # The loop must go on: the executive lands, and the deadman needs its beats.
                if self.failure is None:
                    self.failure = f"{type(error).__name__}: {error}"
                    self._rooms.journal.event("error", "control_loop", self.failure)
                self._stop_moving()

    def _note_lateness(self, now_s: float, deadline_s: float) -> None:
        """A tick is due when a frame has been processed, at the latest at its deadline."""
        woken_s, self._woken_s = self._woken_s, None
        lateness_s = max(0.0, now_s - (deadline_s if woken_s is None else min(woken_s, deadline_s)))
        self.lateness_s.append(lateness_s)
        self._lateness_max_s = max(self._lateness_max_s, lateness_s)

    def tick(self, now_s: float) -> None:
        """One control period."""
        rooms = self._rooms
        self.ticks += 1
        status = rooms.autopilot.status()
        left = self.in_offboard and status.flight_mode != "OFFBOARD"
        if left or (self.guidance is not Guidance.NONE and not self.in_own_mode()):
            self.in_offboard = False
            self.guidance = Guidance.NONE  # One more setpoint would restart MAVSDK's own stream against the pilot.
        rooms.heartbeat.beat(self._stage(status))
        self._fleet_time.poll(now_s)
        rooms.team.poll(now_s)
        self.leadership.poll(now_s)
        for command, answer in rooms.team.take_commands(now_s, self._on_command):
            rooms.journal.command(command, answer)
        dt_s = 0.0 if self._last_tick_s is None else now_s - self._last_tick_s
        self._last_tick_s = now_s
        motion = rooms.autopilot.motion()
        self.target = self._target_fusion.update(now_s, self.phase, None if self.perception is None else self.perception.newest)
        new_frame = self._take_obstacles(now_s)
        self._note_camera(now_s)
        self._teamwork.note_silence(now_s)
        flown = self.decision if self.phase == "pursue" and not self.held else None
        self.coordination.poll(now_s, self.phase, self.target, self._obstacles, flown)
        if motion is not None:
            rooms.journal.own(motion, now_s)
            perceived = None if self.perception is None else self.perception.newest
            self._disc_sharing.poll(now_s, motion.state, self.target, perceived)
            if self.perception is not None:
                self.perception.exclude = self._target_fusion.cut_outs(now_s)
            if self.guidance is not Guidance.NONE:
                self._command(now_s, dt_s, _moved_to(motion.state, now_s), now_s - motion.arrived_s, new_frame)
            else:
                self._guards = ()
                self._gaps.pause()
            self._publish(now_s, motion, status.armed and status.landed_state != "ON_GROUND")
        self._record_slow(now_s)

    def _stage(self, status: Status) -> bytes:
        """What the deadman is told. The wish to arm counts: the heartbeat that reports it comes up to a second later.

        A climb that was broken off is one until the autopilot reports another mode: what ends it may not have been commanded yet.
        """
        if not self.in_offboard and (self.phase in CLIMBING_PHASES or self._is_in_climb(status)):
            return CLIMBING
        return ACTIVE if status.armed or self.guidance is not Guidance.NONE else IDLE

    @property
    def last_stage(self) -> bytes:
        """What the deadman is told when this process ends: LEFT where an armed vehicle was last seen in a mode of its climb that
        this app asked for. A lost link is the way to that; PX4 would hold there until its battery is empty.
        """
        return LEFT if self._is_in_climb(self._rooms.autopilot.status()) else IDLE

    def _is_in_climb(self, status: Status) -> bool:
        return status.armed and status.flight_mode in CLIMBING_MODES and self.in_own_mode()

    def _command(self, now_s: float, dt_s: float, own: VehicleState, own_age_s: float, new_frame: bool) -> None:
        rooms = self._rooms
        battery = rooms.autopilot.battery()
        observation = Observation(
            t_s=now_s,
            dt_s=dt_s,
            own=own,
            team=self.coordination.partners(now_s),
            target=self.target,
            obstacles=self._disc_sharing.for_planner(now_s, own, self.target, self._obstacles),
            boundary=rooms.boundary,
            assignment=self.coordination.assignment(),
        )
        context = SafetyContext(
            t_s=now_s,
            dt_s=dt_s,
            name=rooms.vehicle.name,
            own=own,
            own_age_s=own_age_s,
            team=self._teamwork.members(now_s, active_only=False),
            target=self.target,
            obstacles=self._obstacles,
            obstacles_age_s=now_s - self._obstacles.t_s,
            previous=self._previous,
            limits=rooms.limits,
            team_link_age_s=self._teamwork.link_age_s(now_s),
            battery_fraction=None if battery is None else battery.remaining_fraction,
            heights_trusted=vouches_for_position(rooms.autopilot),
        )
        rooms.journal.observation(
            observation,
            context,
            self._last_frame,
            planned=self.guidance is Guidance.PLANNER,
            held=self.held or self.is_detoured,
        )
        if rooms.tracker is not None:
            rooms.tracker.watch(own, dt_s)
        wish = self._wish(observation)
        supervised = rooms.supervisor.check(wish, context)
        self._note_demand(supervised.demand)
        setpoint = supervised.setpoint
        if rooms.tracker is not None:
            forward = rooms.tracker.forward(setpoint)
            setpoint = with_feed_forward(setpoint, forward, rooms.limits, rooms.profile.safety)
        rooms.autopilot.send(setpoint)
        sent_s = rooms.clock.now_s()
        self.setpoints_sent += 1
        self._gaps.note(sent_s)
        self._previous = setpoint
        if rooms.tracker is not None:
            rooms.tracker.note(setpoint)
        self._guards = tuple(name for name, _ in supervised.acting)
        clearance = clearance_in_space_m(own.position_ned_m, self._obstacles.discs, rooms.limits.body_radius_m)
        self._clearance_m = None if clearance >= NO_OBSTACLE_M else clearance
        frame_s = None if self._last_frame is None else self._obstacles.t_s
        rooms.journal.setpoint(wish, setpoint, frame_s, new_frame, supervised.acting, self._clearance_m, sent_s)

    def _note_demand(self, demand: Demand | None) -> None:
        """An event when what the supervisor asks for changes."""
        before, self.demand = self.demand, demand
        if demand is not None and (before is None or before.action != demand.action or before.guard != demand.guard):
            text = f"{demand.guard} asks for {demand.action.name.lower()}: {demand.reason}"
            self._rooms.journal.event("warning", "safety", text, action=demand.action.name.lower(), guard=demand.guard)
        elif demand is None and before is not None:
            self._rooms.journal.event("info", "safety", f"{before.guard} no longer asks for {before.action.name.lower()}")

    def _wish(self, observation: Observation) -> Setpoint:
        """What planner, planned way or hover want. A planner that is held or taken a detour from is asked all the same: else
        nobody would see that it has recovered.
        """
        planned = self._planned(observation) if self.guidance is Guidance.PLANNER else None
        way = self._way if self.guidance is Guidance.WAY else self._detour if self.is_detoured else None
        yields = self._way_yields or self.guidance is Guidance.PLANNER
        if way is not None and self.held and yields:
            way.pause()
        elif way is not None:
            self._hover.restart()
            self._hover.keep_height_of(observation.own)
            return self._turned(way.setpoint(observation.own, observation.t_s, self._yaw_rad))
        if planned is None or self.held or self.is_detoured:
            return self._hover.setpoint(observation.own, self._yaw_rad)
        self._hover.restart()
        self._hover.keep_mission_height()
        if self._rooms.tracker is not None:
            planned = self._rooms.tracker.wish(planned)
        return self._turned(planned)

    def _turned(self, wish: Setpoint) -> Setpoint:
        """The wish; its yaw is what a hover keeps."""
        if math.isfinite(wish.yaw_rad):
            self._yaw_rad = wish.yaw_rad
        return wish

    def _planned(self, observation: Observation) -> Setpoint | None:
        """The planner's wish with the height loop; None where it failed."""
        rooms = self._rooms
        started_s = rooms.clock.now_s()
        try:
            decision = rooms.planner.step(observation)
        except Exception as error:  # The planner is exchangeable; whatever it raises, the vehicle keeps hovering.
            if self.planner_failure is None:
                self.planner_failure = f"{type(error).__name__}: {error}"
            return None
        latency_s = rooms.clock.now_s() - started_s
        self.decision, self.decision_latency_s = decision, latency_s
        self.decision_is_finite = bool(np.isfinite(decision.velocity_ned_m_s).all()) and math.isfinite(decision.yaw_rad)
        rooms.journal.decision(decision, latency_s, observation.t_s)
        self._search_record.note(observation)
        if decision.reason:
            level = "warning" if decision.mode in NEEDS_HELP else "info"
            rooms.journal.event(level, "mode", f"{decision.mode}: {decision.reason}", mode=decision.mode)
        return wish_of(decision, self._hover, observation.own, feed_forward=rooms.profile.control.acceleration_feed_forward)

    def obstacles_age_s(self, now_s: float) -> float:
        """Since the newest obstacle picture was true."""
        return now_s - self._obstacles.t_s

    def _stop_moving(self) -> None:
        """Replace the setpoint that MAVSDK would go on repeating by standing still."""
        if self.guidance is not Guidance.NONE:
            with contextlib.suppress(Exception):
                self._rooms.autopilot.send(Setpoint(np.zeros(3), self._yaw_rad))

    def _take_obstacles(self, now_s: float) -> bool:
        """Newest obstacles; True when they come from a frame that was not used before."""
        if self.perception is None:
            self._obstacles = ObstacleSet(now_s, self._rooms.surveyed.discs, self._rooms.surveyed.unseen)
            return False
        newest = self.perception.newest
        if newest is None or newest.frame_number == self._last_frame:
            return False
        self._last_frame = newest.frame_number
        self._obstacles = newest.obstacles
        self._rooms.journal.obstacles(newest, now_s)
        return True

    def _note_camera(self, now_s: float) -> None:
        """Events of the camera, and when depth frames stop coming and come again; the guards act on the age itself."""
        if self.perception is None:
            return
        for notice in self.perception.take_notices():
            self._rooms.journal.event(notice.level, "camera", notice.text)
        if self._last_frame is None:
            return
        age_s = now_s - self._obstacles.t_s
        silent = age_s > self._rooms.profile.safety.obstacles_age_max_s
        if silent != self._camera_silent:
            self._camera_silent = silent
            text = f"no depth frame for {age_s:.1f} s" if silent else "depth frames come again"
            self._rooms.journal.event("warning" if silent else "info", "camera", text)

    def _publish(self, now_s: float, motion: Motion, airborne: bool) -> None:
        """Share the own state at the profile's rate."""
        if now_s < self._publish_due_s:
            return
        self._publish_due_s = max(self._publish_due_s + 1.0 / self._rooms.profile.network.state_rate_hz, now_s)
        state, intent = self._teamwork.describe(
            now_s,
            motion.state,
            airborne=airborne,
            phase=self.phase,
            decision=self._told_decision(),
            outcome=self.outcome,
            target=self.target,
            clearance_m=self._clearance_m,
            guards=self._guards,
        )
        self._teamwork.tell(state, intent, now_s)

    def _told_decision(self) -> Decision | None:
        """What the others hear of the planner's decision: on a detour it is not what the vehicle does."""
        if self.guidance is not Guidance.PLANNER or self.decision is None:
            return None
        return replace(self.decision, mode=DETOUR) if self.is_detoured else self.decision

    def _record_slow(self, now_s: float) -> None:
        """What is recorded less often than every tick: on change or by period."""
        rooms = self._rooms
        if now_s - self._team_recorded_s >= TEAM_PERIOD_S * 0.95:
            self._team_recorded_s = now_s
            rooms.journal.team(rooms.team.peers.values(), now_s)
        status = rooms.autopilot.status()
        seen = (status.flight_mode, status.armed, status.landed_state, status.connected)
        due = now_s - self._status_recorded_s >= STATUS_PERIOD_S * 0.95
        if due or seen != self._status_seen:
            self._status_seen = seen
            rooms.journal.status(status, now_s)
        for arrived_s, severity, text in rooms.autopilot.take_status_texts():
            level = "info" if severity in ("DEBUG", "INFO", "NOTICE") else "warning"
            rooms.journal.event(level, "autopilot", text, severity=severity, arrived_s=arrived_s)
        if not due:
            return
        self._status_recorded_s = now_s
        battery = rooms.autopilot.battery()
        if battery is not None:
            rooms.journal.battery(battery, now_s)
        memory_mb = self._process.memory_info().rss / 1e6
        cpu = self._process.cpu_percent() / 100.0
        rooms.journal.health(cpu, memory_mb, self._lateness_max_s, self.setpoints_sent, self._gaps.take(), now_s)
        self._lateness_max_s = 0.0


def _moved_to(state: VehicleState, now_s: float) -> VehicleState:
    """`state` carried forward by its own velocity, at most MOTION_EXTRAPOLATION_MAX_S."""
    ahead_s = min(MOTION_EXTRAPOLATION_MAX_S, max(0.0, now_s - state.t_s))
    return VehicleState(now_s, state.position_ned_m + state.velocity_ned_m_s * ahead_s, state.velocity_ned_m_s, state.yaw_rad)

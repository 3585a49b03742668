"""From live values to recorded messages: the only place where the runtime meets the recorder.

Values of the fast channels are handed over as they are and become messages in the recorder's thread: they are immutable.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from flightapp.core.clock import Clock
from flightapp.core.types import Array, Decision, Observation, Setpoint, TargetTrack, VehicleState
from flightapp.estimation.target_filter import Fit
from flightapp.fleet.clock_offset import Offset
from flightapp.fleet.coordination.plan import Plan
from flightapp.fleet.messages.command import Acknowledgement, Command
from flightapp.fleet.peers import Peer
from flightapp.planning.ac2f.candidates import STANDING_M_S, Candidates
from flightapp.recording import messages
from flightapp.recording.observation import observation_record
from flightapp.recording.recorder import Recorder
from flightapp.runtime.perception_thread import Perceived
from flightapp.safety.api import SafetyContext
from flightapp.vehicle.autopilot import BatteryState, Motion, Status
from flightapp.vehicle.gap_meter import Gaps

if TYPE_CHECKING:
    from flightapp.runtime.way_planner import PlannedWay

WAY_SPACING_M = 1.0
"""About so far apart are the places that are recorded of a planned way."""
LEVELS = {"info": logging.INFO, "warning": logging.WARNING, "error": logging.ERROR}


class Journal:
    """Writes one vehicle's story; every method is cheap and never raises into the control loop."""

    def __init__(self, recorder: Recorder, clock: Clock, vehicle: str) -> None:
        self._recorder = recorder
        self._clock = clock
        self._log = logging.getLogger(vehicle)

    @property
    def flush_slowest_s(self) -> float:
        """Longest time that handing the recording to the disk has taken so far."""
        return self._recorder.flush_slowest_s

    @property
    def recording_error(self) -> str | None:
        """Why nothing is recorded any more; None while all is well."""
        return self._recorder.error

    def event(self, level: str, name: str, text: str, **data: object) -> None:
        """Record an event and print it as a line."""
        now_s = self._clock.now_s()
        self._log.log(LEVELS[level], "%s: %s", name, text)
        self._recorder.log("/event", messages.Event(now_s, level, name, text, data), now_s)

    def command(self, command: Command, answer: Acknowledgement) -> None:
        """An operator's command and what was answered to it."""
        verdict = "accepted" if answer.accepted else "refused"
        text = f"{command.action} from {command.operator or 'an operator'} {verdict}: {answer.text}"
        self.event(
            "warning",
            "command",
            text,
            action=command.action,
            operator=command.operator,
            identifier=command.identifier,
            sent_s=command.sent_s,
            accepted=answer.accepted,
        )

    def phase(self, phase: str, reason: str, outcome: str | None) -> None:
        now_s = self._clock.now_s()
        self._log.info("phase %s%s%s", phase, f" ({reason})" if reason else "", f", outcome {outcome}" if outcome else "")
        self._recorder.log("/phase", messages.Phase(now_s, phase, reason, outcome), now_s)

    def own(self, motion: Motion, now_s: float) -> None:
        self._recorder.log("/own", lambda: _own(motion, now_s), now_s)

    def target(self, track: TargetTrack, now_s: float) -> None:
        self._recorder.log("/target", lambda: _target(track), now_s)

    def sighting(
        self,
        t_s: float,
        source: str,
        vehicle: str,
        place: tuple[float, float],
        sigma_m: float,
        fit: Fit,
        now_s: float,
    ) -> None:
        """A measurement of the evader and how it fitted."""
        distance_m, nis = (None if math.isnan(number) else number for number in (fit.distance_m, fit.nis))
        record = messages.TargetSighting(now_s, t_s, source, vehicle, *place, sigma_m, fit.is_used, distance_m, nis)
        self._recorder.log("/sighting", record, now_s)

    def team(self, peers: Iterable[Peer], now_s: float) -> None:
        members = [
            messages.Teammate(
                state.vehicle,
                state.role,
                list(state.position_ned_m),
                list(state.velocity_ned_m_s),
                state.mode,
                state.phase,
                state.eta_s,
                now_s - state.t_s,
                peer.lost,
                peer.taken,
            )
            for peer in peers
            if (state := peer.state) is not None
        ]
        self._recorder.log("/team", messages.Team(now_s, members), now_s)

    def plan(self, plan: Plan, leader: str, now_s: float) -> None:
        seats = [
            messages.PlanSeat(seat.vehicle, seat.bearing_rad, seat.north_m, seat.east_m, seat.alone_s) for seat in plan.seats
        ]
        record = messages.TeamPlan(now_s, leader, plan.term, plan.version, plan.arrival_s, seats)
        self._recorder.log("/plan", record, now_s)

    def way(self, way: PlannedWay) -> None:
        """A way that was planned, or why there is none: an event, and the places that it leads past."""
        name = way.purpose.replace(" ", "_")
        if way.trajectory is None:
            self.event("warning", name, way.text)
            return
        self.event("info", name, way.text)
        now_s, trajectory = self._clock.now_s(), way.trajectory
        times = np.linspace(0.0, trajectory.duration_s, 2 + int(trajectory.length_m / WAY_SPACING_M))
        places = [trajectory.at(float(t_s)).position_ned_m.round(2).tolist() for t_s in times]
        self._recorder.log("/way", messages.Way(now_s, way.purpose, trajectory.duration_s, way.gap_m, places), now_s)

    def clock_offsets(self, offsets: Mapping[str, Offset], now_s: float) -> None:
        known = [messages.ClockOffset(name, offset.ahead_s, offset.uncertainty_s) for name, offset in offsets.items()]
        self._recorder.log("/clocks", messages.ClockOffsets(now_s, known), now_s)

    def clock_offset_changed(self, name: str, offset: Offset, ahead_s: Mapping[str, float]) -> None:
        """An event, and metadata of the recording with all offsets, for whoever merges the recordings of several machines."""
        text = (
            f"clock of {name} is {offset.ahead_s * 1e3:+.1f} ms ahead of this one, give or take "
            f"{offset.uncertainty_s * 1e3:.1f} ms; its stamps are corrected by that"
        )
        self.event("info", "clock", text, peer=name, ahead_s=offset.ahead_s, uncertainty_s=offset.uncertainty_s)
        self._recorder.metadata("clock_offsets", ahead_s)

    def obstacles(self, perceived: Perceived, now_s: float) -> None:
        self._recorder.log("/obstacles", lambda: _obstacles(perceived, now_s), now_s)

    def observation(
        self, observation: Observation, context: SafetyContext, frame_number: int | None, *, planned: bool, held: bool
    ) -> None:
        """What planner and supervisor are given in this period, for replay."""
        self._recorder.log(
            "/observation",
            lambda: observation_record(observation, context, frame_number, planned=planned, held=held),
            observation.t_s,
        )

    def decision(self, decision: Decision, latency_s: float, now_s: float) -> None:
        self._recorder.log("/decision", lambda: _decision(decision, latency_s, now_s), now_s)

    def candidates(self, candidates: Candidates, own: VehicleState, now_s: float) -> None:
        """What the dynamic window weighed in this step."""
        self._recorder.log("/candidates", lambda: _candidates(candidates, own, now_s), now_s)

    def setpoint(
        self,
        wish: Setpoint,
        setpoint: Setpoint,
        frame_s: float | None,
        new_frame: bool,
        acting: tuple[tuple[str, str], ...],
        clearance_m: float | None,
        now_s: float,
    ) -> None:
        """What the supervisor made of `wish`."""
        self._recorder.log("/setpoint", lambda: _setpoint(wish, setpoint, frame_s, new_frame, acting, clearance_m, now_s), now_s)

    def status(self, status: Status, now_s: float) -> None:
        self._recorder.log(
            "/autopilot",
            messages.AutopilotStatus(
                now_s, status.connected, status.flight_mode, status.armed, status.landed_state, now_s - status.heartbeat_s
            ),
            now_s,
        )

    def battery(self, battery: BatteryState, now_s: float) -> None:
        self._recorder.log("/battery", messages.Battery(now_s, battery.voltage_v, battery.remaining_fraction), now_s)

    def health(
        self,
        cpu_fraction: float,
        memory_mb: float,
        lateness_max_s: float,
        setpoints: int,
        gaps: Gaps | None,
        now_s: float,
    ) -> None:
        self._recorder.log(
            "/health",
            messages.Health(
                now_s,
                cpu_fraction,
                memory_mb,
                lateness_max_s * 1e3,
                self._recorder.dropped,
                setpoints,
                None if gaps is None else gaps.p50_ms,
                None if gaps is None else gaps.p99_ms,
                None if gaps is None else gaps.max_ms,
                dict(self._recorder.drops),
                self._recorder.flush_slowest_s,
            ),
            now_s,
        )


def _own(motion: Motion, now_s: float) -> messages.OwnState:
    state = motion.state
    position, velocity = state.position_ned_m.tolist(), state.velocity_ned_m_s.tolist()
    return messages.OwnState(
        state.t_s, position, velocity, motion.roll_rad, motion.pitch_rad, state.yaw_rad, now_s - motion.arrived_s
    )


def _target(track: TargetTrack) -> messages.Target:
    variance = float(track.covariance[0, 0] + track.covariance[1, 1])
    return messages.Target(
        track.t_s,
        track.position_ned_m.tolist(),
        track.velocity_ned_m_s.tolist(),
        math.sqrt(max(0.0, variance)),
        track.age_s,
    )


def _obstacles(perceived: Perceived, now_s: float) -> messages.Obstacles:
    health = perceived.health
    return messages.Obstacles(
        now_s,
        perceived.frame_s,
        perceived.frame_number,
        _finite_rows(perceived.obstacles.discs),
        perceived.obstacles.unseen.tolist(),
        perceived.processing_s,
        health.skipped,
        list(perceived.events),
        perceived.age_s.tolist(),
        perceived.confidence.tolist(),
        perceived.latency_s,
        health.processed,
        health.without_pose,
        health.source.lost,
        health.source.restarts,
        health.source.temperature_c,
        health.source.fault,
    )


def _decision(decision: Decision, latency_s: float, now_s: float) -> messages.DecisionRecord:
    return messages.DecisionRecord(
        now_s,
        decision.velocity_ned_m_s.tolist(),
        decision.yaw_rad,
        decision.mode,
        None if decision.goal_ned_m is None else decision.goal_ned_m.tolist(),
        decision.reason,
        latency_s,
        dict(decision.diagnostics),
    )


def _candidates(candidates: Candidates, own: VehicleState, now_s: float) -> messages.Candidates:
    north_m, east_m, down_m = own.position_ned_m.tolist()
    north_m_s, east_m_s, _ = own.velocity_ned_m_s.tolist()
    is_standing = math.hypot(north_m_s, east_m_s) < STANDING_M_S
    course_rad = own.yaw_rad if is_standing else math.atan2(east_m_s, north_m_s)
    admissible = candidates.verdicts == 0
    return messages.Candidates(
        now_s,
        north_m,
        east_m,
        down_m,
        course_rad,
        candidates.horizon_s,
        candidates.speeds_m_s.round(3).tolist(),
        candidates.turns_rad_s.round(3).tolist(),
        np.where(admissible, candidates.scores, 0.0).round(4).tolist(),
        candidates.verdicts.tolist(),
        candidates.best,
    )


def _setpoint(
    wish: Setpoint,
    setpoint: Setpoint,
    frame_s: float | None,
    new_frame: bool,
    acting: tuple[tuple[str, str], ...],
    clearance_m: float | None,
    now_s: float,
) -> messages.SetpointRecord:
    forward = setpoint.acceleration_ned_m_s2
    return messages.SetpointRecord(
        now_s,
        setpoint.velocity_ned_m_s.tolist(),
        setpoint.yaw_rad,
        frame_s,
        new_frame,
        [list(pair) for pair in acting],
        clearance_m,
        wish.velocity_ned_m_s.tolist(),
        wish.yaw_rad,
        None if forward is None else forward.tolist(),
    )


def _finite_rows(discs: Array) -> list[list[float | None]]:
    """JSON has no infinity: unknown heights become null."""
    return [[value if math.isfinite(value) else None for value in row] for row in discs.tolist()]

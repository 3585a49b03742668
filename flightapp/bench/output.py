"""What leaves a vehicle in one control period: six recorded messages, and its state for the fleet."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from flightapp.bench.measurement import Measurement, Work, measure
from flightapp.bench.situation import far
from flightapp.core.clock import SystemClock
from flightapp.core.types import Decision, Limits, Observation, Setpoint
from flightapp.fleet.messages.codec import Header, decode, encode
from flightapp.fleet.messages.state import STATE, State
from flightapp.planning.registry import make_planner
from flightapp.recording.recorder import Recorder
from flightapp.runtime.journal import Journal
from flightapp.runtime.perception_thread import Perceived, PerceptionHealth
from flightapp.runtime.vehicle_process import THREAD_SWITCH_S
from flightapp.safety.api import SafetyContext
from flightapp.vehicle.autopilot import Motion
from perception.sources.api import SourceHealth

PAUSE_S = 0.005
"""Faster than any control loop, slow enough for the recorder's thread to keep up."""
RECORDER_AIM_MS = 0.2


@dataclass(frozen=True, slots=True)
class _Tick:
    """What one control period has in hand when it is recorded."""

    seen: Observation
    context: SafetyContext
    motion: Motion
    perceived: Perceived
    decision: Decision
    wish: Setpoint
    number: int


def recorder_measurement(limits: Limits, seconds: float) -> Measurement:
    """Own state, target, obstacles, observation, decision and setpoint of one period into a real recording with its small log.

    Measured is what the control loop waits for. The recorder's thread works at the same time, in the pauses and beside.
    """
    planner = make_planner("ac2f", limits=limits)

    def decide(k: int) -> _Tick:
        seen = far(k)
        decision = planner.step(seen)
        rows = len(seen.obstacles.discs)
        health = PerceptionHealth(SourceHealth())
        perceived = Perceived(seen.obstacles, np.zeros(rows), np.ones(rows), seen.t_s, k, 0.03, 0.001, health)
        wish = Setpoint(decision.velocity_ned_m_s, decision.yaw_rad)
        return _Tick(seen, _context(seen, limits), Motion(seen.own, 0.0, 0.0, seen.t_s), perceived, decision, wish, k)

    with tempfile.TemporaryDirectory() as name, _vehicles_thread_switch():
        folder = Path(name)
        with Recorder(folder / "bench.mcap", small_path=folder / "bench.small.mcap") as recorder:
            journal = Journal(recorder, SystemClock(), "bench")

            def record(tick: _Tick) -> None:
                now_s = tick.seen.t_s
                journal.own(tick.motion, now_s)
                if tick.seen.target is not None:
                    journal.target(tick.seen.target, now_s)
                journal.obstacles(tick.perceived, now_s)
                journal.observation(tick.seen, tick.context, tick.number, planned=True, held=False)
                journal.decision(tick.decision, 0.0002, now_s)
                journal.setpoint(tick.wish, tick.wish, now_s, True, (), 1.0, now_s)

            work = Work("recorder, six messages of a tick", decide, record, aim_ms=RECORDER_AIM_MS, pause_s=PAUSE_S)
            found = measure(work, seconds)
            if recorder.dropped:
                raise RuntimeError(f"{recorder.dropped} messages were dropped: dropping is cheaper than recording")
    return found


@contextmanager
def _vehicles_thread_switch() -> Iterator[None]:
    """Threads take turns as in a vehicle process."""
    before_s = sys.getswitchinterval()
    sys.setswitchinterval(THREAD_SWITCH_S)
    try:
        yield
    finally:
        sys.setswitchinterval(before_s)


def _context(seen: Observation, limits: Limits) -> SafetyContext:
    return SafetyContext(
        t_s=seen.t_s,
        dt_s=seen.dt_s,
        name="bench",
        own=seen.own,
        own_age_s=0.01,
        team=seen.team,
        target=seen.target,
        obstacles=seen.obstacles,
        obstacles_age_s=0.03,
        previous=None,
        limits=limits,
        team_link_age_s=0.03,
        battery_fraction=0.8,
    )


def fleet_measurement(seconds: float) -> Measurement:
    """One shared state to bytes and back."""

    state = State(
        t_s=0.0,
        position_ned_m=(12.3, -4.5, -5.0),
        velocity_ned_m_s=(3.0, 0.4, 0.0),
        yaw_rad=0.1,
        airborne=True,
        phase="pursue",
        outcome=None,
    )

    def stamped(k: int) -> tuple[State, Header]:
        return replace(state, t_s=k / 20.0 - 0.013), Header("p1", k, k / 20.0)

    return measure(Work("fleet state, encode and decode", stamped, lambda sent: decode(STATE, encode(STATE, *sent))), seconds)

"""What leaves a vehicle in one control period: six recorded messages, and its state for the fleet."""

from __future__ import annotations

import tempfile
from dataclasses import replace
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
from flightapp.safety.api import SafetyContext
from flightapp.vehicle.autopilot import Motion
from perception.sources.api import SourceHealth

PAUSE_S = 0.002
"""Faster than any control loop, slow enough for the recorder's thread to keep up."""


def recorder_measurement(limits: Limits, seconds: float) -> Measurement:
    """Own state, target, obstacles, decision and setpoint of one period into a real recording in a temporary folder."""
    planner = make_planner("ac2f", limits=limits)

    def decide(k: int) -> tuple[Observation, Decision, int]:
        seen = far(k)
        return seen, planner.step(seen), k

    with tempfile.TemporaryDirectory() as folder, Recorder(Path(folder) / "bench.mcap") as recorder:
        journal = Journal(recorder, SystemClock(), "bench")

        def record(given: tuple[Observation, Decision, int]) -> None:
            seen, decision, number = given
            now_s = seen.t_s
            journal.own(Motion(seen.own, 0.0, 0.0, now_s), now_s)
            if seen.target is not None:
                journal.target(seen.target, now_s)
            rows = len(seen.obstacles.discs)
            journal.obstacles(
                Perceived(
                    seen.obstacles,
                    np.zeros(rows),
                    np.ones(rows),
                    now_s,
                    number,
                    0.03,
                    0.001,
                    PerceptionHealth(SourceHealth()),
                ),
                now_s,
            )
            journal.observation(seen, _context(seen, limits), number, planned=True, held=False)
            journal.decision(decision, 0.0002, now_s)
            wish = Setpoint(decision.velocity_ned_m_s, decision.yaw_rad)
            journal.setpoint(wish, wish, now_s, True, (), 1.0, now_s)

        found = measure(Work("recorder, six messages of a tick", decide, record, pause_s=PAUSE_S), seconds)
        if recorder.dropped:
            raise RuntimeError(f"{recorder.dropped} messages were dropped: dropping is cheaper than recording")
    return found


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

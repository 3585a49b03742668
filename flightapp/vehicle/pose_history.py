"""Recent own motion, to find the pose that belongs to a depth frame.

Position and attitude arrive in messages of their own, each with its own time. They are kept apart and interpolated to
the asked time: at 3 rad/s an attitude taken 20 ms too early moves an obstacle at 8 m by half a metre.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from flightapp.core.angles import wrap_pi
from flightapp.core.types import VehicleState
from flightapp.vehicle.autopilot import Motion

EXTRAPOLATION_MAX_S = 0.15
GAP_MAX_S = 0.3
"""Between two messages further apart the motion is not known: an attitude may have swung there and back."""
RATE_BASELINE_S = 0.015
"""Attitudes at least this far apart give the rate with which the newest one is carried forward."""


class _Attitude(NamedTuple):
    t_s: float
    roll_rad: float
    pitch_rad: float
    yaw_rad: float


class PoseHistory:
    """Bounded history; appended by the telemetry thread, read by the control loop and the perception thread.

    What is kept are tuples that are replaced, never changed, so a reader sees one moment of each without a lock. A message that
    is not newer than those before it (the autopilot restarted, or its clock was found to be offset) replaces them.
    """

    def __init__(self, length: int = 256) -> None:
        self._length = length
        self._states: tuple[VehicleState, ...] = ()
        self._attitudes: tuple[_Attitude, ...] = ()

    def append_state(self, state: VehicleState) -> None:
        older = self._states[-self._length + 1 :]
        while older and older[-1].t_s >= state.t_s:
            older = older[:-1]
        self._states = (*older, state)

    def append_attitude(self, t_s: float, roll_rad: float, pitch_rad: float, yaw_rad: float) -> None:
        older = self._attitudes[-self._length + 1 :]
        while older and older[-1].t_s >= t_s:
            older = older[:-1]
        self._attitudes = (*older, _Attitude(t_s, roll_rad, pitch_rad, yaw_rad))

    @property
    def oldest_s(self) -> float:
        """From when on both position and attitude are known; inf before the first messages."""
        states, attitudes = self._states, self._attitudes
        return max(states[0].t_s, attitudes[0].t_s) if states and attitudes else math.inf

    @property
    def newest_s(self) -> float:
        """Up to when both position and attitude are known without extrapolation; -inf before the first messages."""
        states, attitudes = self._states, self._attitudes
        return min(states[-1].t_s, attitudes[-1].t_s) if states and attitudes else -math.inf

    def at(self, t_s: float) -> Motion | None:
        """Motion at `t_s`, interpolated or extrapolated by at most EXTRAPOLATION_MAX_S; None where it is not known."""
        state, attitude = self._state_at(t_s), self._attitude_at(t_s)
        if state is None or attitude is None:
            return None
        return Motion(
            VehicleState(t_s, state.position_ned_m, state.velocity_ned_m_s, attitude.yaw_rad),
            attitude.roll_rad,
            attitude.pitch_rad,
            t_s,
        )

    def _state_at(self, t_s: float) -> VehicleState | None:
        states = self._states
        if not states or t_s - states[-1].t_s > EXTRAPOLATION_MAX_S:
            return None
        newer = states[-1]
        if t_s >= newer.t_s:
            return VehicleState(
                t_s, newer.position_ned_m + newer.velocity_ned_m_s * (t_s - newer.t_s), newer.velocity_ned_m_s, newer.yaw_rad
            )
        for older in reversed(states[:-1]):
            if older.t_s <= t_s:
                if newer.t_s - older.t_s > GAP_MAX_S:
                    return None
                part = (t_s - older.t_s) / (newer.t_s - older.t_s)
                position = older.position_ned_m + part * (newer.position_ned_m - older.position_ned_m)
                velocity = older.velocity_ned_m_s + part * (newer.velocity_ned_m_s - older.velocity_ned_m_s)
                return VehicleState(t_s, position, velocity, newer.yaw_rad)
            newer = older
        return None

    def _attitude_at(self, t_s: float) -> _Attitude | None:
        attitudes = self._attitudes
        if not attitudes or t_s - attitudes[-1].t_s > EXTRAPOLATION_MAX_S:
            return None
        newer = attitudes[-1]
        if t_s >= newer.t_s:
            return _carried_forward(attitudes, t_s)
        for older in reversed(attitudes[:-1]):
            if older.t_s <= t_s:
                return _between(older, newer, t_s) if newer.t_s - older.t_s <= GAP_MAX_S else None
            newer = older
        return None


def _carried_forward(attitudes: tuple[_Attitude, ...], t_s: float) -> _Attitude:
    """The newest attitude at the rate of the last ones, `t_s` after it; as it was, where no rate was measured lately."""
    newest = attitudes[-1]
    older = next((a for a in reversed(attitudes) if newest.t_s - a.t_s >= RATE_BASELINE_S), None)
    if older is None or newest.t_s - older.t_s > GAP_MAX_S:
        return newest
    return _between(older, newest, t_s)


def _between(older: _Attitude, newer: _Attitude, t_s: float) -> _Attitude:
    """On the straight way from `older` to `newer` and beyond."""
    part = (t_s - older.t_s) / (newer.t_s - older.t_s)
    return _Attitude(
        t_s,
        older.roll_rad + part * math.remainder(newer.roll_rad - older.roll_rad, math.tau),
        older.pitch_rad + part * (newer.pitch_rad - older.pitch_rad),
        wrap_pi(older.yaw_rad + part * wrap_pi(newer.yaw_rad - older.yaw_rad)),
    )

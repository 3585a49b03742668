"""What the team knows of the evader: noisy, late, lost behind obstacles; optionally through the application's filter."""

from __future__ import annotations

import numpy as np

from flightapp.core.types import Array, TargetTrack
from flightapp.estimation.target_filter import TargetFilter
from flightapp.sim.batch.noise import normal
from flightapp.sim.batch.period import DOWN_M
from flightapp.sim.batch.scenario import Scenario

SIGMA_MIN = 0.01
"""Standard deviation that a measurement without noise claims, m and m/s."""


class TargetSight:
    """One track for the whole team."""

    def __init__(self, scenario: Scenario, key: int) -> None:
        target = scenario.target
        self._target = target
        self._key = key
        self._latency_steps = round(target.latency_s / scenario.sub_step_s)
        self._sub_steps, self._sub_step_s = scenario.sub_steps, scenario.sub_step_s
        self._filter = TargetFilter() if target.filter else None
        self._sigmas = max(SIGMA_MIN, target.position_noise_m), max(SIGMA_MIN, target.velocity_noise_m_s)
        self._covariance = np.diag([self._sigmas[0] ** 2] * 3 + [self._sigmas[1] ** 2] * 3)
        self._measured: tuple[float, Array, Array] | None = None

    def track(self, tick: int, t_s: float, poses: Array, seen: bool) -> TargetTrack | None:
        """The track at control period `tick`; `seen`: the evader was measured. poses: (h, n, 5), see keep_pose."""
        if seen:
            self._measure(tick, poses)
        if self._measured is None:
            return None
        measured_s, position, velocity = self._measured
        if self._filter is not None:
            return self._filter.predict(t_s)
        return TargetTrack(measured_s, position, velocity, self._covariance, t_s - measured_s)

    def _measure(self, tick: int, poses: Array) -> None:
        step = max(0, tick * self._sub_steps - self._latency_steps)
        n, e, vn, ve, _ = poses[step % len(poses), -1].tolist()
        far, fast = self._target.position_noise_m, self._target.velocity_noise_m_s
        if far > 0.0:
            n, e = n + far * normal(self._key, tick, 0, 0), e + far * normal(self._key, tick, 0, 1)
        if fast > 0.0:
            vn, ve = vn + fast * normal(self._key, tick, 1, 0), ve + fast * normal(self._key, tick, 1, 1)
        measured_s = step * self._sub_step_s
        self._measured = (measured_s, np.array((n, e, DOWN_M)), np.array((vn, ve, 0.0)))
        if self._filter is not None:
            self._filter.update(*self._measured, *self._sigmas)

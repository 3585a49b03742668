"""The fine stage (section 5): a dynamic window over speed and turn rate with admissibility, memory and adaptive weights."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from flightapp.core.types import Array, Limits
from flightapp.planning import critics
from flightapp.planning.ac2f.free_gap import widest_gap_bearing
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.rollout import ADMISSIBLE, BRAKING, COLLISION, roll_out
from flightapp.planning.ac2f.window import Window
from flightapp.planning.plane import Point

STANDING_M_S = 0.1
TERMS = ("heading", "clearance", "velocity", "memory")


@dataclass(frozen=True, slots=True)
class Motion:
    """Where the vehicle is in the sense of the unicycle: position (m), course (rad), speed (m/s), turn rate (rad/s)."""

    position: Point
    course_rad: float
    speed_m_s: float
    turn_rad_s: float


@dataclass(frozen=True, slots=True)
class Choice:
    """The chosen arc; `look_rad` is set where the vehicle stands and must turn to a free gap."""

    speed_m_s: float
    turn_rad_s: float
    look_rad: float | None = None
    best: Mapping[str, object] | None = None
    tally: Mapping[str, int] = field(default_factory=dict)

    @property
    def admissible(self) -> bool:
        return self.best is not None


def adaptive_weights(parameters: Ac2fParameters, near: bool, memory_weight: float) -> dict[str, float]:
    """(alpha, beta, gamma) at a distance, (gamma, beta, alpha) near the evader; memory is a penalty (section 5.1)."""
    alpha, beta, gamma = parameters.weight_heading, parameters.weight_clearance, parameters.weight_velocity
    first, last = (gamma, alpha) if near else (alpha, gamma)
    return {"heading": first, "clearance": beta, "velocity": last, "memory": -memory_weight}


class DynamicWindow:
    """Samples the window of `limits` into buffers of its own and picks the best admissible arc."""

    def __init__(self, parameters: Ac2fParameters, limits: Limits) -> None:
        self._parameters = parameters
        self._limits = limits
        samples = parameters.speed_samples * parameters.turn_samples
        longest = max(parameters.horizon_s, parameters.horizon_terminal_s)
        self._window = Window(limits, parameters.control_period_s, parameters.speed_samples, parameters.turn_samples)
        self._start = np.zeros(3)
        self._scores = np.zeros((len(TERMS), samples))
        self._paths = np.zeros((samples, self._steps(longest), 2))
        self._ends = np.zeros((samples, 3))
        self._clearances = np.zeros(samples)
        self._verdicts = np.zeros(samples, dtype=np.int64)

    def choose(
        self,
        motion: Motion,
        aim: Point,
        speed_limit_m_s: float,
        scene: Array,
        history: Array,
        *,
        near: bool,
        memory_weight: float,
    ) -> Choice:
        """The arc to fly towards `aim` (m) through `scene` (m, 6) past `history` (h, 2)."""
        parameters = self._parameters
        window = self._window
        window.sample(motion.speed_m_s, motion.turn_rad_s, speed_limit_m_s)
        steps = self._steps(parameters.horizon_terminal_s if near else parameters.horizon_s)
        self._roll_out(motion, scene, steps)
        admissible = np.flatnonzero(self._verdicts == ADMISSIBLE)
        if len(admissible) == 0:
            return self._without_admissible(motion, scene)
        weights = adaptive_weights(parameters, near, memory_weight)
        heading, clearance, velocity, memory = self._scores
        critics.heading(self._ends, aim, admissible, heading)
        critics.clearance(self._clearances, parameters.clearance_saturation_m, clearance)
        critics.velocity(window.speeds, velocity)
        if memory_weight != 0.0:
            critics.memory(self._paths, steps, history, parameters.memory_scale_m, admissible, memory)
        best = critics.best(self._scores, [weights[name] for name in TERMS], admissible, raw=parameters.raw_scores)
        found: dict[str, object] = {name: float(score[best]) for name, score in zip(TERMS, self._scores, strict=True)}
        if memory_weight == 0.0:
            del found["memory"]
        return Choice(float(window.speeds[best]), float(window.turns[best]), best={**found, "weights": weights})

    def _steps(self, horizon_s: float) -> int:
        return max(1, round(horizon_s / self._parameters.control_period_s))

    def _roll_out(self, motion: Motion, scene: Array, steps: int) -> None:
        parameters = self._parameters
        self._start[:] = (*motion.position, motion.course_rad)
        roll_out(
            self._start,
            self._window.speeds,
            self._window.turns,
            scene,
            parameters.control_period_s,
            steps,
            parameters.clearance_saturation_m,
            self._limits.acceleration_max_m_s2 * parameters.braking_share,
            parameters.reaction_s,
            parameters.braking_steps,
            self._paths,
            self._ends,
            self._clearances,
            self._verdicts,
        )

    def _without_admissible(self, motion: Motion, scene: Array) -> Choice:
        """Brake along the current arc; standing, turn to the widest free gap (section 5, decision 5)."""
        reasons = {"clearance/collision": COLLISION, "clearance/braking": BRAKING}
        tally = {name: int((self._verdicts == verdict).sum()) for name, verdict in reasons.items()}
        if motion.speed_m_s > STANDING_M_S:
            slower = motion.speed_m_s - self._limits.acceleration_max_m_s2 * self._parameters.control_period_s
            return Choice(max(0.0, slower), motion.turn_rad_s, tally=tally)
        look = widest_gap_bearing(scene, motion.position, self._parameters.clearance_saturation_m)
        return Choice(0.0, 0.0, look_rad=motion.course_rad if look is None else look, tally=tally)


def command_of(motion: Motion, choice: Choice, period_s: float) -> Point:
    """Velocity (m/s) at the end of one control period on the chosen arc."""
    course = motion.course_rad + choice.turn_rad_s * period_s
    return choice.speed_m_s * math.cos(course), choice.speed_m_s * math.sin(course)

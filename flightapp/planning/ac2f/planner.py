"""AC2F: the state machine coarse / fine / tracking around one pursuer's intent and its avoidance."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from flightapp.core.types import Array, Decision, Limits, Observation
from flightapp.planning.ac2f import evaluation
from flightapp.planning.ac2f.apollonius_kernel import HALF_PLANE, REGION_COLUMNS
from flightapp.planning.ac2f.candidates import Candidates, candidates
from flightapp.planning.ac2f.edge import NO_EDGE, Edge
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.recollection import DISCS, blank_recollection
from flightapp.planning.ac2f.records import ACTION, REPORT, blank_memory, parameter_record
from flightapp.planning.ac2f.scene import SCENE_COLUMNS
from flightapp.planning.ac2f.stage import NO_CHANGE, STAGES, sentences
from flightapp.planning.ac2f.step import step
from flightapp.planning.ac2f.surroundings import MEMBER_COLUMNS, TRAIL_COLUMNS, trail_samples
from flightapp.planning.ac2f.workspace import workspace_arrays, workspace_of

NOWHERE = np.zeros(2)
SEEN_S = 3
"""Column of the disc memory."""


class Ac2fPlanner:
    """The strategy `ac2f` and its variants (Zhang et al. 2026). Nothing in it is random."""

    def __init__(self, *, limits: Limits, parameters: Ac2fParameters) -> None:
        self._parameters = parameter_record(parameters, limits)
        self._encircles = parameters.capture.mode != "first"
        self._sentences = sentences(parameters)
        self._trail_samples = trail_samples(parameters)
        self._history = np.zeros((max(parameters.history_samples, int(self._parameters["oscillation_samples"][0])), 2))
        self._action, self._report = np.zeros(1, ACTION), np.zeros(1, REPORT)
        self._positions, self._rows, self._scores, self._verdicts = workspace_arrays(parameters)
        self._scene = np.zeros((0, SCENE_COLUMNS))
        self.reset()

    def reset(self, seed: int | None = None) -> None:
        """Forget everything."""
        del seed
        self._memory = blank_memory()
        self._recollection = blank_recollection()
        self._action["searched"] = 0
        self._edge = NO_EDGE
        self._members = np.zeros((0, MEMBER_COLUMNS))
        self._regions = np.zeros((1, REGION_COLUMNS))
        self._trail = np.zeros((self._trail_samples, TRAIL_COLUMNS))

    def step(self, observation: Observation) -> Decision:
        """One decision; see the class."""
        own, target, obstacles = observation.own, observation.target, observation.obstacles
        assignment = observation.assignment if self._encircles else None
        if self._edge.boundary is not observation.boundary:
            self._edge = Edge.of(observation.boundary)
        self._make_room(len(observation.team), len(obstacles.discs))
        for row, member in enumerate(observation.team):
            north, east, _ = member.state.position_ned_m.tolist()
            v_north, v_east, _ = member.state.velocity_ned_m_s.tolist()
            eta_s = math.nan if member.eta_s is None else member.eta_s
            self._members[row] = north, east, v_north, v_east, member.state.t_s, member.age_s, eta_s
        given = (
            self._parameters,
            self._memory,
            own.position_ned_m,
            own.velocity_ned_m_s,
            own.yaw_rad,
            observation.t_s,
            self._members,
            NOWHERE if target is None else target.position_ned_m,
            NOWHERE if target is None else target.velocity_ned_m_s,
            0.0 if target is None else target.t_s,
            math.nan if target is None else target.age_s,
            math.nan if assignment is None else assignment.bearing_rad,
            math.nan if assignment is None else assignment.arrival_s - observation.t_s,
            obstacles.discs,
            obstacles.t_s,
            obstacles.unseen,
            self._edge.rows,
            observation.boundary.closed,
            self._history,
            self._trail,
            self._scene,
            self._regions,
            self._recollection,
            self._positions,
            self._rows,
            self._scores,
            self._verdicts,
            self._action,
            self._report,
        )
        try:
            step(*given)
        except TypeError:
            step(*map(_plain, given))
        return self._decision()

    def evaluation(self) -> dict[str, object] | None:
        """Every candidate of the last step's dynamic window with its scores, see `evaluation`; None if it searched none."""
        if not self._action[0]["searched"]:
            return None
        workspace = workspace_of(self._positions, self._rows, self._scores, self._verdicts)
        return evaluation.evaluation(self._action, workspace)

    def candidates(self) -> Candidates | None:
        """Some of the candidates that the last step's dynamic window weighed, for the recording; None if it searched none."""
        if not self._action[0]["searched"]:
            return None
        return candidates(self._action, self._rows, self._verdicts, float(self._parameters["horizon_s"][0]))

    def flown(self, velocity_m_s: tuple[float, float]) -> None:
        """The last decision was flown with this planar velocity instead of its own: the next window opens from it."""
        self._memory["command_n"], self._memory["command_e"] = velocity_m_s

    def missed(self) -> None:
        """What the last decision took for a capture was none."""
        self._memory["captured"], self._memory["dwell_since_s"] = 0, math.nan

    def forget_discs(self, places_m: Array, within_m: float) -> None:
        """Do not avoid from memory what is within `within_m` of any of `places_m` (k, 2)."""
        rows = self._recollection[0]["discs"][: int(self._memory["disc_count"][0])]
        apart = np.hypot(rows[:, None, 0] - places_m[None, :, 0], rows[:, None, 1] - places_m[None, :, 1])
        rows[(apart <= within_m).any(axis=1), SEEN_S] = -math.inf

    def _make_room(self, teammates: int, discs: int) -> None:
        if teammates != len(self._members):
            self._members = np.zeros((teammates, MEMBER_COLUMNS))
            self._regions = np.zeros((teammates + 1, REGION_COLUMNS))
            missing = self._trail_samples * (teammates + 1) - len(self._trail)
            if missing > 0:
                self._trail = np.concatenate((self._trail, np.zeros((missing, TRAIL_COLUMNS))))
        if discs + DISCS + teammates + 1 > len(self._scene):
            self._scene = np.zeros((2 * discs + DISCS + teammates + 1, SCENE_COLUMNS))

    def _decision(self) -> Decision:
        (
            north, east, yaw_rad, stage, reason, has_goal, goal_n, goal_e, target_known, distance_m, closest_m, clearance_m,
            surrounded, captured, memory_weight, searched, guided, pursuers, eta_s, contested, point_n, point_e,
        ) = self._report.item()  # fmt: skip
        mode = STAGES[stage]
        diagnostics: dict[str, object] = {
            "stage": mode,
            "target_distance_m": distance_m if target_known else None,
            "eta_s": eta_s if pursuers else None,
            "contested": contested if pursuers else None,
            "game_point": [point_n, point_e] if pursuers else None,
            "circles": [row[1:4] for row in self._regions[:pursuers].tolist() if row[0] != HALF_PLANE],
            "clearance_m": clearance_m,
            "encircled": surrounded,
            "captured": captured,
            "memory_weight": memory_weight,
            "guidance": "guided around a trap" if guided else "",
        }
        if searched:
            diagnostics.update(evaluation.summary(self._action))
        return Decision(
            velocity_ned_m_s=np.array((north, east, 0.0)),
            acceleration_ned_m_s2=None,
            yaw_rad=yaw_rad,
            mode=mode,
            goal_ned_m=np.array((goal_n, goal_e, 0.0)) if has_goal else None,
            reason=self._sentences[reason].format(closest_m=closest_m) if reason != NO_CHANGE else "",
            diagnostics=diagnostics,
        )


def _plain(value: Any) -> Any:
    """Arrays of numbers as a kernel takes them: float64, row by row, writable."""
    if isinstance(value, np.ndarray) and value.dtype.kind == "f":
        return np.require(value, np.float64, ("C", "W"))
    return value

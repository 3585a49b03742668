"""The whole evaluation of the dynamic window, 441 candidates x 10 steps x 40 discs with memory, against plain NumPy."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from flightapp.bench.measurement import Measurement, Work, measure
from flightapp.bench.rollout_reference import fine_reference
from flightapp.bench.situation import FINE_DISTANCE_M, circling, ring
from flightapp.core.types import Array, Limits
from flightapp.planning.ac2f.fine import fine, fine_workspace
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.records import ACTION, INTENT, MEMORY, VIEW, Record, parameter_record

NOTHING_UNSEEN = np.zeros((0, 2))
TURN_RAD_S = 2.0
"""Of the circling."""


@dataclass(frozen=True, slots=True)
class Moment:
    """What the fine stage gets in one period of the circling, trapped in its own history."""

    memory: Record
    view: Record
    intent: Record
    scene: Array
    history: Array


def fine_measurement(limits: Limits, parameters: Ac2fParameters, seconds: float) -> tuple[Measurement, float]:
    """The kernel beside its reference, and the reference's median CPU time in ms."""
    gains, workspace, action = parameter_record(parameters, limits), fine_workspace(parameters), np.zeros(1, ACTION)

    def evaluate(at: Moment) -> None:
        fine(gains, at.memory, at.view, at.intent, at.scene, NOTHING_UNSEEN, at.history, workspace, action)

    def moment(k: int) -> Moment:
        return _moment(limits, parameters, k)

    def evaluated(k: int) -> Moment:
        found = moment(k)
        evaluate(found)
        return found

    def plainly(at: Moment) -> None:
        view, intent = at.view[0], at.intent[0]
        fine_reference(
            np.array((view["ahead_n"], view["ahead_e"], math.atan2(view["base_e"], view["base_n"]))),
            workspace.speeds_m_s,
            workspace.turns_rad_s,
            at.scene,
            parameters.control_period_s,
            round(parameters.horizon_s / parameters.control_period_s),
            parameters.clearance_saturation_m,
            limits.acceleration_max_m_s2 * parameters.braking_share,
            parameters.reaction_s,
            parameters.braking_steps,
            np.array((intent["goal_n"], intent["goal_e"])),
            at.history,
            parameters.memory_scale_m,
            np.array(
                (parameters.weight_heading, parameters.weight_clearance, parameters.weight_velocity, -parameters.memory_weight)
            ),
        )

    name = f"planner, fine evaluation, {len(workspace.speeds_m_s)} samples"
    kernel = measure(Work(name, moment, evaluate), seconds / 2)
    plain = measure(Work("NumPy reference", evaluated, plainly), seconds / 2).cpu_ms.p50
    return replace(kernel, faster_by=plain / kernel.cpu_ms.p50), plain


def _moment(limits: Limits, parameters: Ac2fParameters, k: int) -> Moment:
    own = circling(k)
    north, east, _ = own.position_ned_m.tolist()
    memory, view, intent = np.zeros(1, MEMORY), np.zeros(1, VIEW), np.zeros(1, INTENT)
    memory["trapped"], memory["turn_rad_s"] = 1, TURN_RAD_S
    view["own_n"], view["own_e"] = view["ahead_n"], view["ahead_e"] = north, east
    view["base_n"], view["base_e"] = own.velocity_ned_m_s[:2]
    view["own_yaw_rad"], view["target_known"] = own.yaw_rad, 1
    view["target_n"], view["target_e"] = north + FINE_DISTANCE_M, east
    intent["goal_n"], intent["goal_e"] = north + FINE_DISTANCE_M, east
    intent["velocity_n"] = limits.speed_max_m_s
    discs = ring(own).discs
    scene = np.zeros((len(discs), 6))
    scene[:, :5] = discs[:, :5]
    scene[:, 2] += limits.body_radius_m + limits.safety_margin_m
    view["scene_count"] = view["obstacle_count"] = len(scene)
    past = [circling(k - 3 * j).position_ned_m[:2] for j in range(parameters.history_samples, 0, -1)]
    return Moment(memory, view, intent, scene, np.array(past))

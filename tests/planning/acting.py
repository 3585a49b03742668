"""One moment of a step as the acting kernels get it, in records."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flightapp.core.types import Array
from flightapp.planning.ac2f.fine import Workspace, fine, fine_workspace
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.reactive import hold, react, search
from flightapp.planning.ac2f.records import ACTION, INTENT, MEMORY, VIEW, Record, parameter_record
from tests.planning.closed_loop import limits

Pair = tuple[float, float]
NOTHING = np.zeros((0, 2))


def scene_of(rows: list[tuple[float, ...]]) -> Array:
    return np.array([(*row, 0.0) for row in rows], dtype=np.float64).reshape(-1, 6)


def random_scene(random: np.random.Generator, count: int, moving: bool = True) -> Array:
    bearing, distance = random.uniform(-math.pi, math.pi, count), random.uniform(2.0, 8.0, count)
    scene = np.zeros((count, 6))
    scene[:, 0], scene[:, 1] = distance * np.cos(bearing), distance * np.sin(bearing)
    scene[:, 2] = random.uniform(0.3, 1.5, count)
    if moving:
        scene[:, 3:5] = random.uniform(-2.0, 2.0, (count, 2))
        scene[::3, 3:5] = 0.0
    return scene


@dataclass
class Moment:
    """A vehicle at the origin that moves with `base` (m/s) through `scene`; the rows behind its count must not matter."""

    parameters: Ac2fParameters
    scene: Array
    base: Pair = (0.0, 0.0)
    turn_rad_s: float = 0.0
    own_yaw_rad: float = 0.0
    nose_rad: float = 0.0
    target: Pair = (20.0, 0.0)
    trapped: bool = False
    vehicles: int = 0
    """That many of the last rows of `scene` are vehicles."""

    def __post_init__(self) -> None:
        self.gains = parameter_record(self.parameters, limits())
        self.memory, self.view = np.zeros(1, MEMORY), np.zeros(1, VIEW)
        self.action: Record = np.zeros(1, ACTION)
        self.workspace: Workspace = fine_workspace(self.parameters)
        self.memory["turn_rad_s"], self.memory["yaw_rad"], self.memory["trapped"] = self.turn_rad_s, self.nose_rad, self.trapped
        self.view["base_n"], self.view["base_e"] = self.base
        self.view["own_yaw_rad"], self.view["target_known"] = self.own_yaw_rad, 1
        self.view["target_n"], self.view["target_e"] = self.target
        self.view["scene_count"], self.view["obstacle_count"] = len(self.scene), len(self.scene) - self.vehicles
        self.rows = np.full((len(self.scene) + 3, 6), np.nan)
        self.rows[: len(self.scene)] = self.scene

    def fine(self, wish: Pair, goal: Pair = (20.0, 0.0), history: Array = NOTHING, unseen: Array = NOTHING) -> Record:
        intent = np.zeros(1, INTENT)
        intent["velocity_n"], intent["velocity_e"] = wish
        intent["goal_n"], intent["goal_e"] = goal
        fine(self.gains, self.memory, self.view, intent, self.rows, unseen, history, self.workspace, self.action)
        return self.action[0]

    def react(self, wish: Pair, goal: Pair = (20.0, 0.0), watched: Pair | None = None, unseen: Array = NOTHING) -> Record:
        place = watched or (0.0, 0.0)
        watch = int(watched is not None)
        react(self.gains, self.memory, self.view, self.rows, unseen, *goal, *wish, watch, *place, self.action)
        return self.action[0]

    def search(self, wish: Pair, place: Pair) -> Record:
        search(self.gains, self.memory, self.view, self.rows, NOTHING, *place, *wish, self.action)
        return self.action[0]

    def hold(self) -> Record:
        hold(self.gains, self.memory, self.view, self.rows, self.action)
        return self.action[0]

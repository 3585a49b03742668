"""The trials of a measurement: what stands where, who flies how, for how many frames."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from flightapp.bench.perception_truth.bodies import Body
from flightapp.bench.perception_truth.conditions import CONDITIONS, GOOD, OPEN_FIELDS, QUICK_CONDITIONS, Condition
from flightapp.core.types import Array
from perception.synthetic.scene import Scene
from perception.types import VehiclePose

Kind = Literal["width", "condition", "branch", "open", "moving"]

RATE_HZ = 30.0
FRAMES = 16
"""Half a second and the frame that ends it."""
WIDTHS_M = (0.03, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0)
DISTANCES_M = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0)
BRANCH_LENGTH_M = 1.0
BRANCH_THICKNESS_M = 0.04
BALL_RADIUS_M = 0.35
_POLE_HEIGHT_M = 20.0
_BEARING_MAX_RAD = math.radians(18)
_APPROACH_FROM_M = 9.5
_PASS_AT_M = 1.2
_YAW_RATE_RAD_S = 0.3
_YAW_RATE_WITHOUT_NOISE_RAD_S = 0.05
"""The very same pixels again and again would be taken for a frozen camera, and rightly so."""
_TREES = 40


@dataclass(frozen=True, slots=True)
class Trial:
    """One sequence of frames with one thing in it, or none. The same trial always gives the same frames."""

    kind: Kind
    condition: Condition
    width_m: float
    distance_m: float
    seed: int
    frames: int = FRAMES
    ball_speed_m_s: float = 0.0


@dataclass(frozen=True, slots=True)
class Stage:
    """A trial made concrete. body: what stands there at the start; None in an open field."""

    scene: Scene
    body: Body | None
    start: VehiclePose
    yaw_rate_rad_s: float

    def pose(self, t_s: float) -> VehiclePose:
        """Of the vehicle at a time."""
        start = self.start
        north, east, down = start.position_ned_m
        north += start.velocity_ned_m_s[0] * t_s
        yaw = start.yaw_rad + self.yaw_rate_rad_s * t_s
        return VehiclePose((north, east, down), start.velocity_ned_m_s, start.roll_rad, start.pitch_rad, yaw)

    def body_at(self, t_s: float) -> Body | None:
        """What stands, or flies, there at a time."""
        if self.body is None or self.body.velocity_m_s == (0.0, 0.0):
            return self.body
        (north, east), (v_north, v_east) = self.body.centre_m, self.body.velocity_m_s
        return Body.upright(north + v_north * t_s, east + v_east * t_s, self.body.radius_m, self.body.velocity_m_s)

    def balls(self, t_s: float) -> Array | None:
        """(1, 4) north, east, down, radius of the ball at a time, if it is one that flies."""
        body = self.body_at(t_s)
        if body is None or body.velocity_m_s == (0.0, 0.0):
            return None
        return np.array([[*body.centre_m, self.start.position_ned_m[2], body.radius_m]])


def all_trials(seed: int, quick: bool) -> list[Trial]:
    """Every trial of a measurement; a quick one takes a few of each kind."""
    widths, distances, repeats = ((0.05, 0.5, 2.0), (2.0, 4.0, 8.0), 2) if quick else (WIDTHS_M, DISTANCES_M, 8)
    seeds = iter(range(seed * 1_000_000, (seed + 1) * 1_000_000))
    trials = [Trial("width", GOOD, w, d, next(seeds)) for w in widths for d in distances for _ in range(repeats)]
    for condition in CONDITIONS:
        if quick and condition.name not in QUICK_CONDITIONS:
            continue
        moving = condition.speed_m_s > 0.0
        starts = (_APPROACH_FROM_M,) if moving else (4.0,) if quick else (3.0, 5.0, 7.0)
        times = 1 if quick else 3 if moving else 2
        for width in (0.05, 0.5) if quick else (0.05, 0.1, 0.5):
            for distance in starts:
                frames = _approach_frames(condition) if moving else FRAMES
                trials += [Trial("condition", condition, width, distance, next(seeds), frames) for _ in range(times)]
    branch_at = (2.0, 4.0, 6.0) if quick else DISTANCES_M
    trials += [Trial("branch", GOOD, BRANCH_THICKNESS_M, distance, next(seeds)) for distance in branch_at for _ in range(repeats)]
    fields = OPEN_FIELDS[:4] if quick else OPEN_FIELDS
    for field in fields:
        trials += [Trial("open", field, 0.0, 0.0, next(seeds), 45 if quick else 300) for _ in range(1 if quick else 3)]
    for speed in (2.0,) if quick else (1.0, 2.0, 4.0):
        for distance in (4.0,) if quick else (3.0, 5.0, 7.0):
            moving_trial = (2 * BALL_RADIUS_M, distance)
            trials += [Trial("moving", GOOD, *moving_trial, next(seeds), 45, speed) for _ in range(1 if quick else 3)]
    return trials


def stage(trial: Trial) -> Stage:
    """Where the thing of a trial stands is drawn from its seed; every second one has a line of trees far behind it."""
    random = np.random.default_rng(trial.seed)
    condition = trial.condition
    velocity = (condition.speed_m_s, 0.0, 0.0)
    angles = (math.radians(condition.roll_deg), math.radians(condition.pitch_deg), 0.0)
    start = VehiclePose((0.0, 0.0, -condition.height_m), velocity, *angles)
    trees = _tree_line(random) if "tree line" in condition.name or (trial.kind != "open" and trial.seed % 2) else np.zeros((0, 4))
    if trial.kind == "open":
        return Stage(Scene(cylinders=trees), None, start, _YAW_RATE_RAD_S)
    distance = trial.distance_m + random.uniform(-0.1, 0.1)
    bearing = random.uniform(-_BEARING_MAX_RAD, _BEARING_MAX_RAD)
    if trial.kind == "branch":
        return _with_branch(distance, bearing, start, trees, random)
    radius = trial.width_m / 2
    north, east = (distance + radius) * math.cos(bearing), (distance + radius) * math.sin(bearing)
    if trial.kind == "moving":
        side = 1.0 if random.integers(2) else -1.0
        travel = trial.ball_speed_m_s * trial.frames / RATE_HZ
        ball = Body.upright(distance + radius, -side * travel / 2, radius, (0.0, side * trial.ball_speed_m_s))
        return Stage(Scene(cylinders=trees), ball, start, 0.0)
    if condition.speed_m_s > 0.0:
        east = (_PASS_AT_M + radius) * (1.0 if random.integers(2) else -1.0)
        north = distance + radius
    pole = np.array([[north, east, radius, _POLE_HEIGHT_M]])
    yaw_rate = 0.0 if condition.noise else _YAW_RATE_WITHOUT_NOISE_RAD_S
    return Stage(Scene(cylinders=np.concatenate([pole, trees])), Body.upright(north, east, radius), start, yaw_rate)


def _approach_frames(condition: Condition) -> int:
    """Until the pole beside the way comes near the border of the picture."""
    nearest_m = _PASS_AT_M / math.tan(math.radians(33))
    return int((_APPROACH_FROM_M - nearest_m) / condition.speed_m_s * RATE_HZ)


def _with_branch(distance: float, bearing: float, start: VehiclePose, trees: Array, random: np.random.Generator) -> Stage:
    """A horizontal branch across the line of sight, about as high as the vehicle, hanging free."""
    radius = BRANCH_THICKNESS_M / 2
    centre = (distance + radius) * np.array([math.cos(bearing), math.sin(bearing)])
    half = BRANCH_LENGTH_M / 2 * np.array([-math.sin(bearing), math.cos(bearing)])
    down = start.position_ned_m[2] + random.uniform(-0.4, 0.4)
    (n0, e0), (n1, e1) = (centre - half).tolist(), (centre + half).tolist()
    scene = Scene(cylinders=trees, capsules=np.array([[n0, e0, down, n1, e1, down, radius]]))
    return Stage(scene, Body((n0, e0, n1, e1), radius), start, 0.0)


def _tree_line(random: np.random.Generator) -> Array:
    """(n, 4) trees all around, 12 to 25 m away."""
    bearing, distance = random.uniform(-math.pi, math.pi, _TREES), random.uniform(12.0, 25.0, _TREES)
    radius, height = random.uniform(0.15, 0.6, _TREES), random.uniform(6.0, 15.0, _TREES)
    distance += radius
    return np.column_stack([distance * np.cos(bearing), distance * np.sin(bearing), radius, height])

"""One trial: render it, perceive it, hold what came out against what is there."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from flightapp.bench.perception_truth.bodies import Body
from flightapp.bench.perception_truth.conditions import Condition
from flightapp.bench.perception_truth.trials import RATE_HZ, Stage, Trial, stage
from flightapp.config.profile import Profile
from flightapp.core.types import Array
from flightapp.sim.camera import intrinsics_of
from perception.geometry import CameraPose, camera_pose
from perception.pipeline import PerceptionPipeline
from perception.synthetic.depth_renderer import DEPTH_UNIT_M, DepthRenderer
from perception.types import DepthFrame, Intrinsics, PerceivedObstacles, VehiclePose

NEAR_M = 0.3
"""A disc within this of a thing's surface, and three standard deviations of the depth noise, stands for that thing."""
NOISE_1_M = 0.004
ASIDE_M = 0.1
"""A line of sight that passes a disc by less than this is blocked by it."""
_SAME_M = 0.7
"""A false disc this close to one in the frame before is the same one."""
_FAST_M_S = 0.5
_BEARINGS_RAD = np.radians(np.arange(-180.0, 180.0))
_LOOK_M = 3.0
_NOISE_SEEDS = 2
"""The renderer's noise tables take long to make; every frame looks at another part of them."""


@dataclass(slots=True)
class Score:
    """One trial, frame by frame; NaN where there is nothing to measure.

    distance_m: of the nearest surface. found: whether a disc seen in this frame stands for the thing. held: whether any disc
    does, remembered ones too. is_free: the thing, or part of it, is neither covered by a disc nor unseen. false_discs: that
    appeared in this frame. Errors: of the nearest surface (positive = too far), of the centre, of the radius, of the velocity.
    seen_wrongly, unseen_wrongly: of the bearings outside and inside of the picture, how many were reported otherwise.
    """

    trial: Trial
    distance_m: list[float] = field(default_factory=list)
    found: list[bool] = field(default_factory=list)
    held: list[bool] = field(default_factory=list)
    is_free: list[bool] = field(default_factory=list)
    false_discs: list[int] = field(default_factory=list)
    surface_error_m: list[float] = field(default_factory=list)
    centre_error_m: list[float] = field(default_factory=list)
    radius_error_m: list[float] = field(default_factory=list)
    velocity_error_m_s: list[float] = field(default_factory=list)
    moves_wrongly: list[bool] = field(default_factory=list)
    seen_wrongly: list[tuple[int, int]] = field(default_factory=list)
    unseen_wrongly: list[tuple[int, int]] = field(default_factory=list)


def score_trial(trial: Trial, profile: Profile) -> Score:
    """Fly a trial with the camera and the perception parameters of a profile."""
    camera, intrinsics = profile.camera, intrinsics_of(profile.camera)
    condition = trial.condition
    flown = stage(trial)
    renderer = DepthRenderer(
        flown.scene,
        intrinsics,
        range_min_m=camera.range_min_m,
        noise=condition.noise,
        seed=trial.seed % _NOISE_SEEDS,
        flaws=condition.flaws,
    )
    pipeline = PerceptionPipeline(
        profile.perception, camera.mounting, range_min_m=camera.range_min_m, range_max_m=camera.range_max_m
    )
    error_rad = np.random.default_rng(trial.seed).normal(0.0, math.radians(condition.pose_error_deg), 3).tolist()
    score = Score(trial)
    false_before = np.zeros((0, 2))
    for number in range(trial.frames):
        t_s = number / RATE_HZ
        true_pose = flown.pose(t_s)
        true_camera = camera_pose(true_pose, camera.mounting)
        depth = renderer.render(true_camera, trial.seed % 1000 * 1000 + number, flown.balls(t_s))
        told = _told(flown, t_s, condition, error_rad)
        perceived = pipeline.process(DepthFrame(t_s, number, depth, DEPTH_UNIT_M, intrinsics), told)
        false_before = _add(score, perceived, flown.body_at(t_s), flown.scene.cylinders, true_pose, false_before)
        is_told_true = not condition.pose_error_deg and not condition.pose_delay_s
        if is_told_true and condition.flaws.cover is None and condition.flaws.glare is None:
            _add_sectors(score, perceived, true_camera, true_pose, intrinsics, profile.perception.band_m)
    return score


def _told(flown: Stage, t_s: float, condition: Condition, error_rad: list[float]) -> VehiclePose:
    """The pose that perception is told."""
    pose = flown.pose(t_s - condition.pose_delay_s)
    roll, pitch, yaw = error_rad
    return replace(pose, roll_rad=pose.roll_rad + roll, pitch_rad=pose.pitch_rad + pitch, yaw_rad=pose.yaw_rad + yaw)


def _add(
    score: Score, perceived: PerceivedObstacles, body: Body | None, trees: Array, pose: VehiclePose, false_before: Array
) -> Array:
    """Score one frame; returns the false discs (n, 2) in it."""
    viewer = np.array(pose.position_ned_m[:2])
    discs, condition = perceived.discs, score.trial.condition
    is_true = stands_for_a_tree(discs, trees, viewer, condition)
    if body is not None:
        distance = float(body.gap_m(viewer[None])[0])
        gap = body.gap_m(discs[:, :2]) - discs[:, 2]
        stands_for = gap <= _tolerance_m(np.hypot(*(discs[:, :2] - viewer).T), condition)
        is_true |= stands_for
        fresh = stands_for & (perceived.age_s < 0.5 / RATE_HZ)
        score.distance_m.append(distance)
        score.found.append(bool(fresh.any()))
        score.held.append(bool(stands_for.any()))
        score.is_free.append(is_free(perceived, body, viewer, condition))
        _add_errors(score, discs[fresh], body, viewer, distance)
    false = discs[~is_true, :2]
    known = np.hypot(false[:, :1] - false_before[:, 0], false[:, 1:] - false_before[:, 1]) < _SAME_M
    score.false_discs.append(int(np.count_nonzero(~known.any(axis=1))))
    return false


def stands_for_a_tree(discs: Array, trees: Array, viewer: Array, condition: Condition) -> NDArray[np.bool_]:
    """(n,) whether a disc stands for one of the upright cylinders (k, 4) of the scene.

    On an approach the vehicle comes near the line of trees, and aside a tree 12 m away is 9 m deep: what is found there is real.
    """
    gap = np.hypot(discs[:, :1] - trees[:, 0], discs[:, 1:2] - trees[:, 1]) - trees[:, 2] - discs[:, 2:3]
    is_near = gap <= _tolerance_m(np.hypot(*(discs[:, :2] - viewer).T), condition)[:, None]
    found: NDArray[np.bool_] = np.asarray(is_near.any(axis=1), np.bool_)
    return found


def _tolerance_m(distance_m: Array, condition: Condition) -> Array:
    noise = 3.0 * NOISE_1_M * distance_m**2
    return NEAR_M + noise + condition.pose_tolerance_m_per_m * distance_m + condition.pose_tolerance_m


def _add_errors(score: Score, discs: Array, body: Body, viewer: Array, distance_m: float) -> None:
    if not len(discs):
        for errors in (score.surface_error_m, score.centre_error_m, score.radius_error_m, score.velocity_error_m_s):
            errors.append(math.nan)
        score.moves_wrongly.append(False)
        return
    reach = np.hypot(*(discs[:, :2] - viewer).T) - discs[:, 2]
    score.surface_error_m.append(float(reach.min()) - distance_m)
    off = np.hypot(*(discs[:, :2] - np.array(body.centre_m)).T)
    nearest = int(off.argmin())
    is_one = body.is_round and len(discs) == 1
    score.centre_error_m.append(float(off[nearest]) if is_one else math.nan)
    score.radius_error_m.append(float(discs[nearest, 2]) - body.radius_m if is_one else math.nan)
    velocity = discs[nearest, 3:5] - np.array(body.velocity_m_s)
    score.velocity_error_m_s.append(float(math.hypot(*velocity)))
    is_static = body.velocity_m_s == (0.0, 0.0)
    score.moves_wrongly.append(is_static and float(np.hypot(*discs[:, 3:5].T).max()) > _FAST_M_S)


def is_free(perceived: PerceivedObstacles, body: Body, viewer: Array, condition: Condition) -> bool:
    """Whether a visible point of the body is neither behind the front of a disc nor in an unseen sector."""
    points = body.visible_points_m(viewer) - viewer
    distance = np.hypot(*points.T)
    bearing = np.arctan2(points[:, 1], points[:, 0])
    away = perceived.discs[:, :2] - viewer
    along = np.cos(bearing)[:, None] * away[:, 0] + np.sin(bearing)[:, None] * away[:, 1]
    across = np.abs(np.cos(bearing)[:, None] * away[:, 1] - np.sin(bearing)[:, None] * away[:, 0])
    aside = ASIDE_M + condition.pose_tolerance_m_per_m * distance + condition.pose_tolerance_m
    front = np.hypot(*away.T) - perceived.discs[:, 2]
    is_before = front <= (distance + _tolerance_m(distance, condition))[:, None]
    blocks = (along > 0.0) & (across <= perceived.discs[:, 2] + aside[:, None]) & is_before
    return not bool(np.all(is_unseen(perceived.unseen, bearing) | blocks.any(axis=1)))


def is_unseen(unseen: Array, bearing_rad: Array) -> NDArray[np.bool_]:
    """(n,) whether bearings lie in one of the sectors (k, 2)."""
    turn = 2 * math.pi
    into = (bearing_rad[:, None] - unseen[:, 0]) % turn
    inside: NDArray[np.bool_] = np.asarray((into < (unseen[:, 1] - unseen[:, 0])).any(axis=1), np.bool_)
    return inside


def _add_sectors(
    score: Score, perceived: PerceivedObstacles, camera: CameraPose, pose: VehiclePose, k: Intrinsics, band_m: float
) -> None:
    """Bearings that show nothing of the height band at 3 m must be unseen, those that show all of it must not."""
    heights = pose.position_ned_m[2] + np.linspace(-band_m, band_m, 9)
    points = np.empty((len(_BEARINGS_RAD), len(heights), 3))
    points[..., 0] = camera.position_ned_m[0] + _LOOK_M * np.cos(_BEARINGS_RAD)[:, None]
    points[..., 1] = camera.position_ned_m[1] + _LOOK_M * np.sin(_BEARINGS_RAD)[:, None]
    points[..., 2] = heights
    x, y, z = np.moveaxis((points - camera.position_ned_m) @ camera.rotation, 2, 0)
    depth = np.maximum(z, 1e-6)
    u, v = k.fx_px * x / depth + k.cx_px, k.fy_px * y / depth + k.cy_px
    inside = (z > 0.0) & (u >= 0) & (u < k.width_px) & (v >= 0) & (v < k.height_px)
    unseen = is_unseen(perceived.unseen, _BEARINGS_RAD)
    nothing, everything = ~inside.any(axis=1), inside.all(axis=1)
    score.seen_wrongly.append((int(np.count_nonzero(nothing & ~unseen)), int(np.count_nonzero(nothing))))
    score.unseen_wrongly.append((int(np.count_nonzero(everything & unseen)), int(np.count_nonzero(everything))))

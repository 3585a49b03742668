"""The fine stage's roll-out in plain NumPy: what the kernel is tested against and compared with."""

from __future__ import annotations

import numpy as np

from flightapp.core.types import Array


def _moved(pose: Array, ways: Array, turns: Array) -> Array:
    """Poses (n, 3) after chords of length `ways` (n,) in the direction of the middle heading."""
    middle = pose[:, 2] + 0.5 * turns
    return np.stack((pose[:, 0] + ways * np.cos(middle), pose[:, 1] + ways * np.sin(middle), pose[:, 2] + turns), axis=1)


def _clearance(scene: Array, before: Array, after: Array, t_s: Array, step_s: Array) -> Array:
    """Smallest distance (n,) to the moving discs along each chord."""
    if len(scene) == 0:
        return np.full(len(before), np.inf)
    start = before[:, None, :2] - scene[None, :, :2] - scene[None, :, 3:5] * t_s[:, None, None]
    along = (after - before)[:, None, :2] - scene[None, :, 3:5] * step_s[:, None, None]
    length2 = np.maximum((along**2).sum(axis=2), 1e-300)
    fraction = np.clip(-(start * along).sum(axis=2) / length2, 0.0, 1.0)
    nearest = start + fraction[:, :, None] * along
    return np.asarray((np.hypot(nearest[:, :, 0], nearest[:, :, 1]) - scene[None, :, 2]).min(axis=1))


def roll_out_reference(
    start: Array,
    speeds: Array,
    turns: Array,
    scene: Array,
    step_s: float,
    steps: int,
    saturation_m: float,
    deceleration_m_s2: float,
    reaction_s: float,
    braking_steps: int,
) -> tuple[Array, Array, Array]:
    """Clearance (n,), verdict (n,) and end pose (n, 3) of every candidate; arguments as the kernel's."""
    count = len(speeds)
    pose = np.tile(start, (count, 1))
    clearance = np.full(count, saturation_m)
    step = np.full(count, step_s)
    for k in range(steps):
        after = _moved(pose, speeds * step_s, turns * step_s)
        clearance = np.minimum(clearance, _clearance(scene, pose, after, np.full(count, k * step_s), step))
        pose = after
    ends = pose.copy()
    gap = np.full(count, np.inf)
    moving = speeds > 0.0
    brake_step = (reaction_s + speeds / deceleration_m_s2) / braking_steps

    def way(t_s: Array) -> Array:
        braked = np.maximum(0.0, t_s - reaction_s)
        return np.asarray(speeds * t_s - 0.5 * deceleration_m_s2 * braked**2)

    for k in range(braking_steps):
        length = way((k + 1) * brake_step) - way(k * brake_step)
        after = _moved(pose, length, np.where(moving, turns * length / np.where(moving, speeds, 1.0), 0.0))
        gap = np.minimum(gap, _clearance(scene, pose, after, steps * step_s + k * brake_step, brake_step))
        pose = after
    verdict = np.where(clearance <= 0.0, 1, np.where(moving & (gap <= 0.0), 2, 0))
    return clearance, verdict, ends


def fine_reference(
    start: Array,
    speeds: Array,
    turns: Array,
    scene: Array,
    step_s: float,
    steps: int,
    saturation_m: float,
    deceleration_m_s2: float,
    reaction_s: float,
    braking_steps: int,
    aim: Array,
    history: Array,
    memory_scale_m: float,
    weights: Array,
) -> tuple[Array, Array, Array]:
    """The whole evaluation: raw scores (4, n) heading, clearance, velocity, memory; verdict (n,); normalised total (n,).

    aim (2,), history (h, 2) in m; weights (4,). The total is -inf where a candidate is not admissible.
    """
    clearance, verdict, ends = roll_out_reference(
        start, speeds, turns, scene, step_s, steps, saturation_m, deceleration_m_s2, reaction_s, braking_steps
    )
    sight = np.arctan2(aim[1] - ends[:, 1], aim[0] - ends[:, 0])
    heading = np.pi - np.abs((ends[:, 2] - sight + np.pi) % (2.0 * np.pi) - np.pi)
    memory = np.zeros(len(speeds))
    pose = np.tile(start, (len(speeds), 1))
    for _ in range(steps):
        pose = _moved(pose, speeds * step_s, turns * step_s)
        distance2 = ((pose[:, None, :2] - history[None, :, :]) ** 2).sum(axis=2)
        kernel = np.exp(-0.5 * distance2 / memory_scale_m**2)
        memory += np.where(distance2 < (3.0 * memory_scale_m) ** 2, kernel, 0.0).sum(axis=1)
    scores = np.stack((heading, clearance, speeds, memory))
    total = np.full(len(speeds), -np.inf)
    free = verdict == 0
    if free.any():
        chosen = scores[:, free]
        low, span = chosen.min(axis=1, keepdims=True), np.ptp(chosen, axis=1, keepdims=True)
        total[free] = weights @ np.where(span > 1e-12, (chosen - low) / np.maximum(span, 1e-12), 0.0)
    return scores, verdict, total

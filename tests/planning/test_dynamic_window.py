"""The fine stage: kernel against a plain reference, the window, admissibility, weights."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.bench.rollout_reference import roll_out_reference
from flightapp.core.types import Array
from flightapp.planning import critics
from flightapp.planning.ac2f import Ac2fParameters
from flightapp.planning.ac2f.dynamic_window import DynamicWindow, Motion, adaptive_weights
from flightapp.planning.ac2f.free_gap import widest_gap_bearing
from flightapp.planning.ac2f.rollout import roll_out
from flightapp.planning.ac2f.window import Window
from tests.planning.closed_loop import limits

PARAMETERS = Ac2fParameters()
STEP_S, STEPS, SATURATION_M, DECELERATION, REACTION_S, BRAKING_STEPS = 0.1, 10, 2.0, 4.0, 0.3, 6


def scene_of(rows: list[tuple[float, ...]]) -> Array:
    return np.array([(*row, 0.0) for row in rows], dtype=np.float64).reshape(-1, 6)


def random_scene(random: np.random.Generator, count: int, moving: bool = True) -> Array:
    bearing, distance = random.uniform(-math.pi, math.pi, count), random.uniform(2.0, 8.0, count)
    velocity = random.uniform(-2.0, 2.0, (count, 2)) if moving else np.zeros((count, 2))
    scene = np.zeros((count, 6))
    scene[:, 0], scene[:, 1] = distance * np.cos(bearing), distance * np.sin(bearing)
    scene[:, 2] = random.uniform(0.3, 1.5, count)
    scene[:, 3:5] = velocity
    return scene


@pytest.mark.parametrize("seed", range(20))
def test_the_kernel_agrees_with_the_reference(seed: int) -> None:
    random = np.random.default_rng(seed)
    scene = random_scene(random, 40)
    start = np.array((0.0, 0.0, random.uniform(-3.0, 3.0)))
    speeds, turns = random.uniform(0.0, 5.0, 441), random.uniform(-3.0, 3.0, 441)
    paths, ends, clearances = np.zeros((441, STEPS, 2)), np.zeros((441, 3)), np.zeros(441)
    verdicts = np.zeros(441, dtype=np.int64)
    roll_out(
        start, speeds, turns, scene, STEP_S, STEPS, SATURATION_M, DECELERATION, REACTION_S, BRAKING_STEPS,
        paths, ends, clearances, verdicts,
    )  # fmt: skip
    clearance, verdict, end = roll_out_reference(
        start, speeds, turns, scene, STEP_S, STEPS, SATURATION_M, DECELERATION, REACTION_S, BRAKING_STEPS
    )
    np.testing.assert_array_equal(verdicts, verdict)
    free = verdict != 1
    np.testing.assert_allclose(clearances[free], clearance[free], atol=1e-9)
    np.testing.assert_allclose(ends[free], end[free], atol=1e-9)


def test_the_kernel_refuses_another_layout() -> None:
    scene = random_scene(np.random.default_rng(0), 40)[::2]
    with pytest.raises(TypeError):
        roll_out(
            np.zeros(3), np.zeros(1), np.zeros(1), scene, 0.1, 1, 2.0, 4.0, 0.3, 1,
            np.zeros((1, 1, 2)), np.zeros((1, 3)), np.zeros(1), np.zeros(1, dtype=np.int64),
        )  # fmt: skip


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.0, 5.0), st.floats(-3.0, 3.0), st.booleans())
def test_a_choice_is_inside_the_window_and_its_arc_stops_clear(seed: int, speed: float, turn: float, near: bool) -> None:
    random = np.random.default_rng(seed)
    scene = random_scene(random, 12, moving=False)
    scene[:, 2] = np.minimum(scene[:, 2], np.hypot(scene[:, 0], scene[:, 1]) - 0.5)
    vehicle = limits()
    window = DynamicWindow(PARAMETERS, vehicle)
    motion = Motion((0.0, 0.0), 0.0, speed, turn)
    choice = window.choose(motion, (5.0, 0.0), 5.0, scene, np.zeros((0, 2)), near=near, memory_weight=0.0)
    assert 0.0 <= choice.speed_m_s <= vehicle.speed_max_m_s
    assert abs(choice.turn_rad_s) <= vehicle.yaw_rate_max_rad_s + 1e-9
    assert abs(choice.speed_m_s - speed) <= vehicle.acceleration_max_m_s2 * PARAMETERS.control_period_s + 1e-9
    if not choice.admissible:
        assert sum(choice.tally.values()) == PARAMETERS.speed_samples * PARAMETERS.turn_samples
        return
    assert abs(choice.speed_m_s * choice.turn_rad_s) <= vehicle.acceleration_max_m_s2 + 1e-6
    position, heading, v = np.zeros(2), 0.0, choice.speed_m_s
    horizon = PARAMETERS.horizon_terminal_s if near else PARAMETERS.horizon_s
    t_s, dt = 0.0, 0.005
    while v > 0.0:
        curvature = choice.turn_rad_s / choice.speed_m_s
        position += v * dt * np.array((math.cos(heading), math.sin(heading)))
        heading += curvature * v * dt
        t_s += dt
        if t_s > horizon + PARAMETERS.reaction_s:
            v -= 4.0 * dt
        assert (np.hypot(*(scene[:, :2] - position).T) - scene[:, 2]).min() > -0.05


def test_standing_before_a_wall_all_around_turns_to_the_gap() -> None:
    ring = [(math.cos(a), math.sin(a), 0.35, -math.cos(a), -math.sin(a)) for a in np.arange(-2.4, 2.5, 0.4)]
    window = DynamicWindow(PARAMETERS, limits())
    choice = window.choose(
        Motion((0.0, 0.0), 0.0, 0.0, 0.0), (5.0, 0.0), 5.0, scene_of(ring), np.zeros((0, 2)), near=False, memory_weight=0.0
    )
    assert not choice.admissible
    assert choice.speed_m_s == 0.0
    assert choice.look_rad is not None
    assert abs(choice.look_rad) > 2.5


def test_moving_without_admissible_arc_brakes() -> None:
    wall = scene_of([(1.0, east, 0.5, 0.0, 0.0) for east in np.arange(-4.0, 4.1, 0.5)])
    choice = DynamicWindow(PARAMETERS, limits()).choose(
        Motion((0.0, 0.0), 0.0, 4.0, 0.0), (5.0, 0.0), 5.0, wall, np.zeros((0, 2)), near=False, memory_weight=0.0
    )
    assert not choice.admissible
    assert choice.speed_m_s == pytest.approx(3.5)


def test_widest_gap() -> None:
    assert widest_gap_bearing(scene_of([]), (0.0, 0.0), 5.0) is None
    behind = scene_of([(-1.0, 0.0, 0.3, 0.0, 0.0)])
    assert widest_gap_bearing(behind, (0.0, 0.0), 5.0) == pytest.approx(0.0, abs=1e-9)


def test_weights_swap_exactly() -> None:
    far, near = adaptive_weights(PARAMETERS, False, 0.0), adaptive_weights(PARAMETERS, True, 0.15)
    assert (far["heading"], far["clearance"], far["velocity"]) == (near["velocity"], near["clearance"], near["heading"])
    assert near["memory"] == -0.15


def weighted(scores: Array, weights: Array, admissible: Array, *, raw: bool) -> Array:
    """Total score (k,) of the admissible candidates, in plain NumPy."""
    chosen = scores[:, admissible]
    if raw:
        return np.asarray(weights @ chosen)
    low, span = chosen.min(axis=1, keepdims=True), np.ptp(chosen, axis=1, keepdims=True)
    return np.asarray(weights @ np.where(span > 1e-12, (chosen - low) / np.maximum(span, 1e-12), 0.0))


@given(st.integers(0, 10_000), st.booleans())
def test_the_best_score_is_normalised_over_the_admissible_or_raw(seed: int, raw: bool) -> None:
    random = np.random.default_rng(seed)
    scores, weights = random.normal(0.0, 5.0, (4, 60)), random.uniform(-1.0, 1.0, 4)
    scores[random.integers(4)] = 1.0
    weights[random.integers(4)] = 0.0
    admissible = np.sort(random.choice(60, random.integers(1, 60), replace=False))
    total = weighted(scores, weights, admissible, raw=raw)
    found = critics.best(scores, weights.tolist(), admissible, raw=raw)
    assert total[np.flatnonzero(admissible == found)[0]] == pytest.approx(total.max(), abs=1e-9)


def test_of_equal_scores_the_first_is_best() -> None:
    assert critics.best(np.ones((2, 5)), [0.5, 0.5], np.array((2, 3, 4))) == 2


def test_memory_and_heading_against_plain_numpy() -> None:
    random = np.random.default_rng(3)
    everything = np.arange(9)
    paths, history = random.normal(0.0, 1.0, (9, 4, 2)), random.normal(0.0, 1.0, (5, 2))
    distance2 = ((paths[:, :, None, :] - history[None, None, :, :]) ** 2).sum(axis=3)
    expected = np.where(distance2 < 2.25, np.exp(-distance2 / 0.5), 0.0).sum(axis=(1, 2))
    out = np.zeros(9)
    critics.memory(paths, 4, history, 0.5, everything, out)
    np.testing.assert_allclose(out, expected)
    ends = random.normal(0.0, 3.0, (9, 3))
    sight = np.arctan2(2.0 - ends[:, 1], 1.0 - ends[:, 0])
    turn = np.abs((ends[:, 2] - sight + np.pi) % (2 * np.pi) - np.pi)
    critics.heading(ends, (1.0, 2.0), everything, out)
    np.testing.assert_allclose(out, np.pi - turn)


def test_the_window_is_a_plain_grid() -> None:
    vehicle = limits()
    window = Window(vehicle, 0.1, 21, 21)
    window.sample(4.8, 0.5, 5.0)
    speeds = np.repeat(np.linspace(4.3, 5.0, 21), 21)
    sideways = vehicle.acceleration_max_m_s2 / speeds
    turns = np.clip(np.tile(np.linspace(-0.7, 1.7, 21), 21), -sideways, sideways)
    np.testing.assert_allclose(window.speeds, speeds, atol=1e-12)
    np.testing.assert_allclose(window.turns, turns, atol=1e-12)

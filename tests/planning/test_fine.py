"""The fine stage: kernels against a plain reference, the window, admissibility, memory, weights."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from flightapp.bench.rollout_reference import fine_reference
from flightapp.core.types import Array
from flightapp.planning.ac2f.elementary import angle, sin_cos
from flightapp.planning.ac2f.free_gap import free_gap_rad
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.critics import best_candidate, memory_score
from tests.planning.acting import Moment, random_scene, scene_of
from tests.planning.closed_loop import limits

PARAMETERS = Ac2fParameters()
SEEDS = st.integers(0, 100_000)


def reference(moment: Moment, aim: Array, history: Array, weights: Array, near: bool) -> tuple[Array, Array, Array]:
    parameters, found = moment.parameters, moment.workspace
    course = math.atan2(moment.base[1], moment.base[0])
    return fine_reference(
        np.array((0.0, 0.0, course)),
        found.speeds_m_s,
        found.turns_rad_s,
        moment.scene,
        parameters.control_period_s,
        round((parameters.horizon_terminal_s if near else parameters.horizon_s) / parameters.control_period_s),
        parameters.clearance_saturation_m,
        limits().acceleration_max_m_s2 * parameters.braking_share,
        parameters.reaction_s,
        parameters.braking_steps,
        aim,
        history,
        parameters.memory_scale_m,
        weights,
    )


@settings(max_examples=60, deadline=None)
@given(SEEDS, st.floats(0.31, 5.0), st.floats(-3.0, 3.0), st.booleans(), st.sampled_from([0, 3, 40]), st.integers(0, 40))
def test_the_evaluation_agrees_with_plain_numpy(
    seed: int, speed: float, turn: float, near: bool, discs: int, remembered: int
) -> None:
    random = np.random.default_rng(seed)
    course = random.uniform(-math.pi, math.pi)
    base = (speed * math.cos(course), speed * math.sin(course))
    target = (2.0, 1.0) if near else (12.0, 9.0)
    history = random.normal(0.0, 0.8, (remembered, 2))
    moment = Moment(PARAMETERS, random_scene(random, discs), base, turn, target=target, trapped=True)
    action = moment.fine((3.0, 4.0), history=history)
    alpha, beta, gamma = PARAMETERS.weight_heading, PARAMETERS.weight_clearance, PARAMETERS.weight_velocity
    weights = np.array((gamma, beta, alpha, -0.15) if near else (alpha, beta, gamma, -0.15))
    horizon_s = PARAMETERS.horizon_terminal_s if near else PARAMETERS.horizon_s
    aim = np.array((0.6, 0.8)) * (PARAMETERS.aim_distance_m + limits().speed_max_m_s * horizon_s)
    scores, verdict, total = reference(moment, aim, history[-PARAMETERS.history_samples :], weights, near)
    np.testing.assert_array_equal(moment.workspace.verdicts, verdict)
    assert (action["collisions"], action["brakings"]) == ((verdict == 1).sum(), (verdict == 2).sum())
    free = verdict == 0
    np.testing.assert_allclose(moment.workspace.scores[:, free], scores[:, free], atol=1e-9)
    if not free.any():
        assert action["best"] == -1
        return
    best = action["best"]
    assert total[best] == pytest.approx(total.max(), abs=1e-9)
    assert [action[name] for name in ("heading", "clearance", "velocity", "memory")] == list(moment.workspace.scores[:, best])
    v, w = moment.workspace.speeds_m_s[best], moment.workspace.turns_rad_s[best]
    end = math.atan2(base[1], base[0]) + w * PARAMETERS.control_period_s
    assert (action["velocity_n"], action["velocity_e"]) == pytest.approx((v * math.cos(end), v * math.sin(end)))
    assert moment.memory["turn_rad_s"][0] == w


@settings(max_examples=60, deadline=None)
@given(SEEDS, st.floats(0.0, 5.0), st.floats(-3.0, 3.0), st.booleans())
def test_a_command_is_inside_the_window_and_its_arc_stops_clear(seed: int, speed: float, turn: float, near: bool) -> None:
    random = np.random.default_rng(seed)
    scene = random_scene(random, 12, moving=False)
    scene[:, 2] = np.minimum(scene[:, 2], np.hypot(scene[:, 0], scene[:, 1]) - 0.5)
    vehicle = limits()
    moment = Moment(PARAMETERS, scene, (speed, 0.0), turn, target=(2.0, 0.0) if near else (20.0, 0.0))
    action = moment.fine((5.0, 0.0))
    v, w = math.hypot(action["velocity_n"], action["velocity_e"]), moment.memory["turn_rad_s"][0]
    assert v <= vehicle.speed_max_m_s + 1e-9
    assert abs(v - speed) <= vehicle.acceleration_max_m_s2 * PARAMETERS.control_period_s + 1e-9
    assert abs(w) <= vehicle.yaw_rate_max_rad_s + 1e-9
    if action["best"] < 0:
        assert action["collisions"] + action["brakings"] == PARAMETERS.speed_samples * PARAMETERS.turn_samples
        return
    assert abs(w - turn) <= vehicle.yaw_acceleration_max_rad_s2 * 0.1 + 1e-9 or abs(v * w) <= vehicle.acceleration_max_m_s2 + 1e-6
    assert abs(v * w) <= vehicle.acceleration_max_m_s2 + 1e-6
    t_s = np.arange(0.0, 1.0 + PARAMETERS.reaction_s + v / 4.0, 0.005)
    held_s = (PARAMETERS.horizon_terminal_s if near else PARAMETERS.horizon_s) + PARAMETERS.reaction_s
    pace = np.clip(v - 4.0 * np.maximum(0.0, t_s - held_s), 0.0, None)
    way = np.cumsum(pace) * 0.005
    heading = w / max(v, 1e-9) * way
    places = np.cumsum(pace[:, None] * np.stack((np.cos(heading), np.sin(heading)), axis=1), axis=0) * 0.005
    gaps = np.hypot(places[:, None, 0] - scene[:, 0], places[:, None, 1] - scene[:, 1]) - scene[:, 2]
    assert gaps.min() > -0.05


def test_a_way_free_is_flown_at_top_speed_but_the_goal_itself_as_aim_is_not_passed() -> None:
    top_speed = (limits().speed_max_m_s, 0.0)
    onwards = Moment(PARAMETERS, scene_of([]), top_speed).fine(top_speed, goal=(3.0, 0.0))
    weights = {"weight_heading": 0.64, "weight_clearance": 0.05, "weight_velocity": 0.31}
    literal = Moment(Ac2fParameters(aim="goal", **weights), scene_of([]), top_speed).fine(top_speed, goal=(3.0, 0.0))
    assert onwards["velocity_n"] == pytest.approx(limits().speed_max_m_s)
    assert literal["velocity_n"] < limits().speed_max_m_s - 0.1


def test_without_admissibility_a_way_into_a_wall_is_flown_until_it_touches() -> None:
    wall = scene_of([(4.6 * math.cos(a), 4.6 * math.sin(a), 0.5, 0.0, 0.0) for a in np.arange(0.0, 6.28, 0.1)])
    careful = Moment(PARAMETERS, wall, (4.0, 0.0)).fine((5.0, 0.0))
    literal = Moment(Ac2fParameters(admissibility=False), wall, (4.0, 0.0)).fine((5.0, 0.0))
    assert careful["best"] < 0
    assert careful["brakings"] > 0
    assert literal["best"] >= 0
    assert literal["brakings"] == 0


def test_moving_without_admissible_arc_brakes_along_the_present_one() -> None:
    wall = scene_of([(1.0, east, 0.5, 0.0, 0.0) for east in np.arange(-4.0, 4.1, 0.5)])
    moment = Moment(PARAMETERS, wall, (4.0, 0.0), 0.5)
    action = moment.fine((5.0, 0.0))
    assert action["best"] == -1
    assert math.hypot(action["velocity_n"], action["velocity_e"]) == pytest.approx(3.5)
    assert math.atan2(action["velocity_e"], action["velocity_n"]) == pytest.approx(0.05)
    assert moment.memory["turn_rad_s"][0] == 0.5


def test_standing_before_a_wall_all_around_turns_to_the_gap() -> None:
    ring = [(math.cos(a), math.sin(a), 0.35, -math.cos(a), -math.sin(a)) for a in np.arange(-2.4, 2.5, 0.4)]
    action = Moment(PARAMETERS, scene_of(ring)).fine((5.0, 0.0))
    assert action["best"] == -1
    assert math.hypot(action["velocity_n"], action["velocity_e"]) == 0.0
    assert math.cos(action["yaw_rad"]) < math.cos(2.5)


def test_widest_gap() -> None:
    assert math.isnan(free_gap_rad(scene_of([]), 0.0, 0.0, 5.0))
    assert math.cos(free_gap_rad(scene_of([(-1.0, 0.0, 0.3, 0.0, 0.0)]), 0.0, 0.0, 5.0)) == pytest.approx(1.0)
    three = scene_of([(2.0, 0.0, 0.3, 0.0, 0.0), (0.0, 2.0, 0.3, 0.0, 0.0), (-2.0, 0.1, 0.3, 0.0, 0.0)])
    assert math.sin(free_gap_rad(three, 0.0, 0.0, 5.0)) == pytest.approx(-1.0, abs=0.01)
    assert math.isnan(free_gap_rad(three, 0.0, 0.0, 1.0))


def weights_of(parameters: Ac2fParameters, distance_m: float, trapped: bool = False) -> tuple[list[float], float]:
    action = Moment(parameters, scene_of([]), (2.0, 0.0), target=(distance_m, 0.0), trapped=trapped).fine((5.0, 0.0))
    return [action[f"weight_{term}"] for term in ("heading", "clearance", "velocity")], action["weight_memory"]


def test_weights_swap_exactly_below_the_fine_distance() -> None:
    alpha, beta, gamma = PARAMETERS.weight_heading, PARAMETERS.weight_clearance, PARAMETERS.weight_velocity
    assert weights_of(PARAMETERS, PARAMETERS.fine_trigger_m) == ([alpha, beta, gamma], 0.0)
    assert weights_of(PARAMETERS, PARAMETERS.fine_trigger_m - 0.01, trapped=True) == ([gamma, beta, alpha], -0.15)
    assert weights_of(Ac2fParameters(terminal_adaptation=False), 1.0) == ([alpha, beta, gamma], 0.0)


def test_the_horizon_is_short_below_the_fine_distance() -> None:
    ahead = scene_of([(3.5, 0.0, 0.5, 0.0, 0.0)])
    for adapted, collisions in ((True, False), (False, True)):
        parameters = Ac2fParameters(terminal_adaptation=adapted, admissibility=False)
        assert bool(Moment(parameters, ahead, (4.0, 0.0), target=(3.0, 0.0)).fine((5.0, 0.0))["collisions"]) == collisions


def test_memory_leads_away_from_where_the_vehicle_has_been() -> None:
    past = np.stack((np.linspace(0.2, 1.5, 20), np.full(20, 0.1)), axis=1)
    keen = Moment(PARAMETERS, scene_of([]), (1.0, 0.0)).fine((5.0, 0.0), history=past)
    wary = Moment(Ac2fParameters(memory_weight=5.0), scene_of([]), (1.0, 0.0), trapped=True).fine((5.0, 0.0), history=past)
    assert abs(keen["velocity_e"]) < 1e-9
    assert wary["velocity_e"] < -0.05


def test_no_faster_than_what_was_seen_allows() -> None:
    action = Moment(PARAMETERS, scene_of([]), (1.5, 0.0)).fine((5.0, 0.0), unseen=np.array([[-0.5, 0.5]]))
    assert math.hypot(action["velocity_n"], action["velocity_e"]) <= PARAMETERS.unseen_speed_m_s + 1e-9


@given(SEEDS, st.booleans())
def test_the_best_score_is_normalised_over_the_admissible_or_raw(seed: int, raw: bool) -> None:
    random = np.random.default_rng(seed)
    scores, weights = random.normal(0.0, 5.0, (4, 60)), random.uniform(-1.0, 1.0, 4)
    scores[random.integers(4)] = 1.0
    verdicts = random.integers(0, 3, 60)
    found = best_candidate(scores, weights, verdicts, raw, np.zeros(60))
    free = verdicts == 0
    chosen = scores[:, free]
    low, span = chosen.min(axis=1, keepdims=True), np.ptp(chosen, axis=1, keepdims=True)
    terms = chosen if raw else np.where(span > 1e-12, (chosen - low) / np.maximum(span, 1e-12), 0.0)
    total = weights @ terms
    assert free[found]
    assert total[np.flatnonzero(free) == found][0] == pytest.approx(total.max(), abs=1e-9)


def test_of_equal_scores_the_first_is_best_and_none_without_admissible() -> None:
    weights, totals = np.array((0.5, 0.5)), np.zeros(5)
    assert best_candidate(np.ones((2, 5)), weights, np.array((1, 2, 0, 0, 0)), False, totals) == 2
    assert best_candidate(np.ones((2, 5)), weights, np.ones(5, np.int64), False, totals) == -1


@given(SEEDS, st.integers(1, 5), st.integers(0, 20), st.booleans())
def test_memory_over_rows_and_over_scattered_candidates(seed: int, row: int, remembered: int, even: bool) -> None:
    random = np.random.default_rng(seed)
    paths, history = random.normal(0.0, 1.0, (2, 4, 3 * row)), random.normal(0.0, 1.0, (remembered, 2))
    if even:
        first, step = random.normal(0.0, 1.0, (2, 4, 3, 1)), random.normal(0.0, 0.3, (2, 4, 3, 1))
        paths = (first + step * np.arange(row)).reshape(2, 4, 3 * row)
    distance2 = (paths[0][:, :, None] - history[:, 0]) ** 2 + (paths[1][:, :, None] - history[:, 1]) ** 2
    expected = np.where(distance2 < 2.25, np.exp(-distance2 / 0.5), 0.0).sum(axis=(0, 2))
    out = np.zeros(3 * row)
    memory_score(
        np.ascontiguousarray(paths[0]), np.ascontiguousarray(paths[1]), history, 0.5, row, np.zeros(3 * row, np.int64), out
    )
    np.testing.assert_allclose(out, expected, atol=1e-9)


@given(st.floats(-1e5, 1e5), st.floats(-1e3, 1e3), st.floats(0.0, 1e3))
def test_elementary_functions(x: float, along: float, across: float) -> None:
    sine, cosine = sin_cos(x)
    assert sine == pytest.approx(math.sin(x), abs=1e-10)
    assert cosine == pytest.approx(math.cos(x), abs=1e-10)
    assume(across > 0.0 or along != 0.0)
    assert angle(across, along) == pytest.approx(math.atan2(across, along), abs=1e-14)


def test_another_layout_is_refused_instead_of_compiled_in_flight() -> None:
    moment = Moment(PARAMETERS, scene_of([(5.0, 0.0, 0.5, 0.0, 0.0)] * 4))
    moment.rows = moment.rows[::2]
    with pytest.raises(TypeError):
        moment.fine((5.0, 0.0))

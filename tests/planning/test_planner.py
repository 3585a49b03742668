"""The planner's interface: registry, parameters, target loss, limits, diagnostics, avoidance of the near things."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.errors import InputError
from flightapp.core.types import Array, Boundary, Observation, ObstacleSet, TargetTrack, TeamMember, VehicleState
from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.planner import Ac2fPlanner
from flightapp.planning.ac2f.variants import VARIANTS
from flightapp.planning.registry import ENCIRCLEMENT, make_evader, make_planner, planner_names
from tests.planning.closed_loop import disc, limits

LINE = Boundary(np.array([[0.0, -50.0], [0.0, 50.0]]), False)


def state(t_s: float, north: float, east: float, velocity: tuple[float, float] = (0.0, 0.0)) -> VehicleState:
    return VehicleState(t_s, np.array((north, east, -5.0)), np.array((*velocity, 0.0)), 0.0)


def observation(
    t_s: float,
    *,
    own: tuple[float, float] = (0.0, 0.0),
    velocity: tuple[float, float] = (0.0, 0.0),
    target: tuple[float, float] | None = (30.0, 0.0),
    age_s: float = 0.0,
    discs: list[list[float]] | None = None,
    unseen: Array | None = None,
    team: tuple[TeamMember, ...] = (),
) -> Observation:
    track = None
    if target is not None:
        track = TargetTrack(t_s, np.array((*target, -5.0)), np.zeros(3), np.eye(6), age_s)
    obstacles = ObstacleSet(t_s, np.array(discs or []).reshape(-1, 7), np.zeros((0, 2)) if unseen is None else unseen)
    return Observation(t_s, 1 / 30, state(t_s, *own, velocity), team, track, obstacles, LINE)


def test_names() -> None:
    assert set(planner_names()) >= {*VARIANTS, *ENCIRCLEMENT}


@pytest.mark.parametrize(
    ("name", "parameters", "words"),
    [
        ("ac3f", {}, "known: ac2f"),
        ("ac2f", {"fine_distance_m": -1.0}, "fine_distance_m = -1.0"),
        ("ac2f", {"fine_distanse_m": 1.0}, "fine_distanse_m is not a parameter"),
        ("ac2f", {"capture": {"radius_m": 0}}, "capture.radius_m = 0"),
        ("ac2f", {"target_lost_s": 1.0}, "must be greater than target_stale_s"),
        ("ac2f", {"horizon_s": math.nan}, "horizon_s"),
    ],
)
def test_bad_input_is_one_sentence(name: str, parameters: dict[str, object], words: str) -> None:
    with pytest.raises(InputError) as error:
        make_planner(name, limits=limits(), parameters=parameters)
    assert words in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("name", "parameters"),
    [("teleport", {}), ("waypoints", {}), ("waypoints", {"waypoints": [1.0, 2.0, 3.0]}), ("hover", {"speed": 1.0})],
)
def test_bad_evaders_are_refused(name: str, parameters: dict[str, object]) -> None:
    with pytest.raises(InputError):
        make_evader(name, limits=limits(), parameters=parameters)


def test_every_parameter_says_what_it_is() -> None:
    assert [name for name, field in Ac2fParameters.model_fields.items() if not field.description] == []


def test_a_target_that_goes_missing_is_searched_then_held() -> None:
    planner = make_planner("ac2f", limits=limits())
    modes = [planner.step(observation(0.0)).mode]
    changes = []
    for tick in range(1, 130):
        decision = planner.step(observation(tick * 0.1, own=(0.1 * tick, 0.0), target=None))
        modes.append(decision.mode)
        if decision.reason:
            changes.append((round(tick * 0.1, 1), decision.mode))
            assert decision.mode != modes[-2]
    assert changes == [(2.1, "search"), (10.1, "hold")]
    assert planner.step(observation(13.1)).mode == "coarse"


def test_without_any_target_it_holds() -> None:
    decision = make_planner("ac2f", limits=limits()).step(observation(0.0, target=None))
    assert decision.mode == "hold"
    assert np.array_equal(decision.velocity_ned_m_s, np.zeros(3))


def test_a_stale_track_is_flown_to_where_it_was_last_predicted() -> None:
    planner = make_planner("ac2f", limits=limits())
    planner.step(observation(0.0, target=(20.0, 5.0)))
    decision = planner.step(observation(3.0, target=(90.0, 5.0), age_s=3.0))
    assert decision.mode == "search"
    assert decision.goal_ned_m is not None
    assert tuple(decision.goal_ned_m[:2]) == (20.0, 5.0)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000))
def test_commands_stay_within_window_and_limits_and_diagnostics_are_plain(seed: int) -> None:
    random = np.random.default_rng(seed)
    vehicle = limits()
    planner = make_planner("ac2f", limits=vehicle)
    own, velocity = random.uniform(-5.0, 5.0, 2), random.uniform(-3.0, 3.0, 2)
    last = velocity
    for tick in range(40):
        discs = [disc(*random.uniform(-8.0, 8.0, 2), random.uniform(0.1, 1.0)) for _ in range(random.integers(0, 15))]
        seen = observation(
            tick / 30, own=tuple(own), velocity=tuple(velocity), target=tuple(random.uniform(-6.0, 6.0, 2)), discs=discs
        )
        decision = planner.step(seen)
        base = last + Ac2fParameters().command_blend * (velocity - last)
        command = decision.velocity_ned_m_s[:2]
        assert np.isfinite(command).all()
        assert np.hypot(*command) <= vehicle.speed_max_m_s + 1e-9
        if decision.mode != "fine":
            assert np.hypot(*(command - base)) <= vehicle.acceleration_max_m_s2 * 0.1 + 1e-9
        assert decision.velocity_ned_m_s[2] == 0.0
        assert -math.pi < decision.yaw_rad <= math.pi
        json.dumps(decision.diagnostics, allow_nan=False)
        for key in ("stage", "target_distance_m", "eta_s", "contested", "game_point", "clearance_m", "encircled", "captured"):
            assert key in decision.diagnostics
        last = command
        velocity = velocity + 0.12 * (command - velocity)
        own = own + velocity / 30


def test_inside_a_margin_it_leaves_and_never_freezes() -> None:
    planner = make_planner("ac2f", limits=limits())
    own, velocity = np.array((0.0, 0.0)), np.zeros(2)
    discs = [disc(0.9, 0.05, 0.4)]
    for tick in range(60):
        decision = planner.step(observation(tick / 30, own=tuple(own), velocity=tuple(velocity), discs=discs))
        velocity = velocity + 0.13 * (decision.velocity_ned_m_s[:2] - velocity)
        own = own + velocity / 30
        assert np.hypot(*(own - (0.9, 0.05))) - 0.4 > 0.35
    assert np.hypot(*own) > 0.5


def test_an_unseen_sector_is_entered_slowly_and_looked_at() -> None:
    planner = make_planner("ac2f", limits=limits())
    ahead = np.array([[-0.5, 0.5]])
    velocity = np.zeros(2)
    for tick in range(60):
        decision = planner.step(observation(tick / 30, velocity=tuple(velocity), unseen=ahead))
        velocity = velocity + 0.13 * (decision.velocity_ned_m_s[:2] - velocity)
    assert np.linalg.norm(decision.velocity_ned_m_s) == pytest.approx(1.5, abs=1e-6)
    assert abs(decision.yaw_rad) < 0.2


def test_a_sighting_of_the_evader_is_not_an_obstacle() -> None:
    planner = make_planner("ac2f", limits=limits())
    sighting = planner.step(observation(0.0, target=(4.5, 0.0), discs=[disc(4.4, 0.1, 0.25)]))
    assert sighting.diagnostics["clearance_m"] == 15.0
    tree = planner.step(observation(0.1, target=(4.5, 0.0), discs=[disc(4.5, 1.0, 0.3)]))
    assert tree.diagnostics["clearance_m"] < 5.0


def test_where_nothing_sees_vehicles_an_obstacle_that_the_evader_flies_through_stays_one() -> None:
    planner = make_planner("ac2f", limits=limits(), parameters={"vehicle_radius_max_m": 0.0})
    for tick in range(30):
        seen = observation(tick / 30, target=(4.0 + tick / 10, 0.0), velocity=(3.0, 0.0), discs=[disc(4.5, 0.1, 0.25)])
        assert planner.step(seen).diagnostics["clearance_m"] < 5.0


@pytest.mark.parametrize("name", ["ac2f", "adversarial", "boundary-seeking", "voronoi-centroid"])
def test_a_teammate_is_predicted_from_the_time_of_its_state_so_once_and_not_twice(name: str) -> None:
    heard = state(9.4, 4.0, -3.0, (-1.0, 3.0))
    moved = state(10.0, 4.0 - 0.6, -3.0 + 1.8, (-1.0, 3.0))
    decisions = []
    for told in (heard, moved):
        team = (TeamMember("p1", told, "coarse", 4.0, 0.6),)
        step = make_planner(name, limits=limits()).step if name == "ac2f" else make_evader(name, limits=limits(2.5)).step
        decisions.append(step(observation(10.0, velocity=(2.0, 0.0), team=team)))
    as_heard, as_moved = decisions
    assert as_moved.velocity_ned_m_s == pytest.approx(as_heard.velocity_ned_m_s, abs=1e-9)
    assert as_moved.diagnostics.get("clearance_m") == pytest.approx(as_heard.diagnostics.get("clearance_m"))


@pytest.mark.parametrize("name", ["boundary-seeking", "straight"])
def test_evaders_reach_the_boundary_and_stop(name: str) -> None:
    evader = make_evader(name, limits=limits(2.5), seed=4)
    own, velocity = np.array((12.0, 3.0)), np.zeros(2)
    discs = [disc(6.0, 3.1, 0.5)] if name == "boundary-seeking" else []
    nearest = math.inf
    for tick in range(400):
        decision = evader.step(observation(tick / 30, own=tuple(own), velocity=tuple(velocity), target=None, discs=discs))
        assert np.linalg.norm(decision.velocity_ned_m_s) <= 2.5 + 1e-9
        velocity = velocity + 0.13 * (decision.velocity_ned_m_s[:2] - velocity)
        own = own + velocity / 30
        nearest = min(nearest, float(np.hypot(*(own - (6.0, 3.1)))) - 0.5)
    assert decision.mode == "crossed"
    assert -3.0 < own[0] < 0.0
    assert name == "straight" or nearest > 0.35


def test_straight_repeats_with_its_seed() -> None:
    def heading(seed: int) -> float:
        return make_evader("straight", limits=limits(2.5), seed=seed).step(observation(0.0, own=(30.0, 0.0))).yaw_rad

    assert heading(1) == heading(1)
    assert heading(1) != heading(2)


def test_waypoints_are_flown_in_order() -> None:
    evader = make_evader("waypoints", limits=limits(2.5), parameters={"waypoints": [5.0, 0.0, 5.0, 9.0]})
    assert evader.step(observation(0.0)).velocity_ned_m_s == pytest.approx((2.5, 0.0, 0.0))
    assert evader.step(observation(0.1, own=(4.5, 0.0))).velocity_ned_m_s[1] > 2.0


def test_the_full_evaluation_is_that_of_the_last_step() -> None:
    planner = Ac2fPlanner(limits=limits(), parameters=Ac2fParameters(stages="fine"))
    planner.step(observation(0.0, target=None))
    assert planner.evaluation() is None
    decision = planner.step(observation(0.1, discs=[disc(4.0, 0.5, 0.5)]))
    found = planner.evaluation()
    assert found is not None
    json.dumps(found, allow_nan=False)
    rows = found["candidates"]
    assert isinstance(rows, list)
    assert len(rows) == 441
    best = rows[found["best"]]
    assert best["verdict"] == "admissible"
    assert math.hypot(*decision.velocity_ned_m_s) == pytest.approx(best["speed_m_s"])
    diagnosed = decision.diagnostics["best"]
    assert isinstance(diagnosed, dict)
    assert diagnosed["weights"] == found["weights"]
    assert all(diagnosed[term] == best[term] for term in ("heading", "clearance", "velocity"))
    assert found["best"] == max(
        (row for row in range(441) if rows[row]["verdict"] == "admissible"), key=lambda row: total(rows, row, found["weights"])
    )


def total(rows: list[dict[str, float]], row: int, weights: dict[str, float]) -> float:
    """The weighted sum of the terms of `row`, each normalised over the admissible rows."""
    result = 0.0
    for term in ("heading", "clearance", "velocity"):
        values = [other[term] for other in rows if other["verdict"] == "admissible"]
        spread = max(values) - min(values)
        result += weights[term] * (rows[row][term] - min(values)) / spread if spread > 1e-12 else 0.0
    return result


def test_arrays_of_another_layout_give_the_same_decision() -> None:
    seen = observation(0.0, own=(1.0, 2.0), velocity=(2.0, 0.5), discs=[disc(4.0, 2.5, 0.5), disc(5.0, 0.0, 0.7)])
    single = np.asfortranarray(seen.obstacles.discs)
    frozen = seen.own.position_ned_m.copy()
    frozen.setflags(write=False)
    other = replace(seen, obstacles=replace(seen.obstacles, discs=single), own=replace(seen.own, position_ned_m=frozen))
    decisions = [make_planner("ac2f", limits=limits()).step(each) for each in (seen, other)]
    assert np.array_equal(decisions[0].velocity_ned_m_s, decisions[1].velocity_ned_m_s)


def test_a_team_may_grow_and_shrink() -> None:
    planner = make_planner("ac2f", limits=limits())
    for step, count in enumerate((1, 0, 4, 2, 4)):
        team = tuple(TeamMember(f"p{k}", state(0.1 * step, 3.0 * k, 6.0), "coarse", 4.0, 0.05) for k in range(count))
        decision = planner.step(observation(0.1 * step, team=team))
        circles = decision.diagnostics["circles"]
        assert isinstance(circles, list)
        assert len(circles) == count + 1

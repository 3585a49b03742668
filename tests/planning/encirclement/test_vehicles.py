"""Vehicles that cannot fly any velocity at once: along their nose, by their jerk, with inertia."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.angles import wrap_pi
from flightapp.core.clearance import way_gap_m
from flightapp.core.types import Array, Limits
from flightapp.planning.encirclement.planner import EncirclementPlanner
from flightapp.planning.encirclement.primitives import Primitive, control_points, derived, mean_squared_jerk, to_rest
from flightapp.planning.encirclement.situation import Looking, Situation
from flightapp.planning.encirclement.unicycle import nose_first
from tests.planning.encirclement.arena import PERIOD_S, member, observation, pursuer

RADIUS_M = 0.15
UNICYCLE = Limits(1.0, 100.0, 1e6, 2.0, 1e4, 2.0, RADIUS_M, 0.0)
HEAVY = Limits(1.0, 2.0, 20.0, 3.0, 12.0, 2.0, RADIUS_M, 0.0)
RING = [(4.0 * math.cos(k * 1.3), 4.0 * math.sin(k * 1.3)) for k in range(4)]
DISCS = [(2.0, 1.0, 0.5), (-2.0, 1.5, 0.6), (0.5, -2.5, 0.5)]
EVADER = (0.3, 0.2)
number = st.floats(-2.0, 2.0).map(lambda value: round(value, 2))
pair = st.tuples(number, number)


def arc(place: Array, yaw_rad: float, command: Array, limits: Limits) -> tuple[Array, float]:
    """One period of a unicycle that turns to the commanded course as fast as it can."""
    speed = float(np.hypot(*command))
    error = wrap_pi(math.atan2(command[1], command[0]) - yaw_rad) if speed > 0.0 else 0.0
    most = limits.yaw_rate_max_rad_s * PERIOD_S
    turn = max(-most, min(most, error))
    way = speed * max(0.0, math.cos(error - turn)) * PERIOD_S
    chord = yaw_rad + turn / 2.0
    bent = way if turn == 0.0 else way * math.sin(turn / 2.0) / (turn / 2.0)
    return place + bent * np.array((math.cos(chord), math.sin(chord))), wrap_pi(yaw_rad + turn)


def test_unicycles_encircle_and_catch_without_touching_anything() -> None:
    team = [pursuer(vehicle="unicycle", limits=UNICYCLE, reaction_s=0.0) for _ in RING]
    places, yaws = np.array(RING) * 1.3, [2.0, -1.0, 0.0, 1.0]
    captured, clearance, separation = False, math.inf, math.inf
    for tick in range(250):
        decisions = []
        for i, planner in enumerate(team):
            mates = [member(f"p{j}", 0.1 * tick, places[j]) for j in range(len(team)) if j != i]
            decisions.append(planner.step(observation(places[i], mates, EVADER, DISCS, t_s=0.1 * tick, yaw_rad=yaws[i])))
        before = places.copy()
        for i, decision in enumerate(decisions):
            command = decision.velocity_ned_m_s[:2]
            if np.hypot(*command) == 0.0:  # a command to stand turns to the commanded yaw
                error = wrap_pi(decision.yaw_rad - yaws[i])
                yaws[i] = wrap_pi(yaws[i] + max(-0.2, min(0.2, error)))
            else:
                places[i], yaws[i] = arc(places[i], yaws[i], command, UNICYCLE)
        clearance = min(clearance, least_gap(before, places))
        separation = min(separation, *(math.dist(places[i], places[j]) for i in range(4) for j in range(i)))
        captured = captured or bool(np.hypot(*(places - EVADER).T).min() <= 1.0)
    assert captured
    assert clearance >= RADIUS_M - 1e-6
    assert separation >= 2 * RADIUS_M - 1e-6


def least_gap(before: Array, after: Array) -> float:
    way = after - before
    return min(way_gap_m(*(before[i] - (n, e)), *way[i], radius) for i in range(len(before)) for n, e, radius in DISCS)


def looked(
    own: tuple[float, float], yaw_rad: float, discs: Sequence[Sequence[float]], velocity: tuple[float, float] = (0.0, 0.0)
) -> Situation:
    planner = pursuer(vehicle="unicycle", limits=UNICYCLE)
    assert isinstance(planner, EncirclementPlanner)
    seen = observation(own, [], (9.0, 9.0), discs, yaw_rad=yaw_rad, velocity=velocity)
    return Looking(UNICYCLE, planner._parameters).look(seen)


@settings(max_examples=40, deadline=None)
@given(st.floats(-3.1, 3.1), pair, st.floats(0.66, 1.0))
def test_an_arc_stays_in_the_safety_cell(yaw_rad: float, wish: tuple[float, float], distance: float) -> None:
    situation = looked((0.0, 0.0), yaw_rad, [(distance, 0.0, 0.5), (0.0, distance + 0.02, 0.5)])
    command, _ = nose_first(situation, wish, UNICYCLE, 80.0)
    end, _ = arc(np.zeros(2), yaw_rad, np.array(command), UNICYCLE)
    planes = situation.planes[: situation.plane_count]
    assert (planes[:, :2] @ end <= planes[:, 2] + 1e-9).all()


def test_with_a_wall_ahead_a_unicycle_turns_on_the_spot() -> None:
    situation = looked((0.0, 0.0), 0.0, [(0.65, 0.0, 0.5)])
    command, yaw = nose_first(situation, (0.0, 1.0), UNICYCLE, 80.0)
    assert command == (0.0, 0.0)
    assert yaw == pytest.approx(math.pi / 2.0)


def test_a_metre_in_a_second_takes_what_is_known() -> None:
    powers = to_rest(np.zeros(2), np.zeros(2), np.zeros(2), np.array([[1.0, 0.0]]), np.array([1.0]))
    assert mean_squared_jerk(powers, np.array([1.0]))[0, 0] == pytest.approx(720.0)
    assert Primitive(0.0, 1.0, powers[:, 0, 0]).at(0.5, 1)[0] == pytest.approx(1.875)


@settings(max_examples=30, deadline=None)
@given(pair, pair, pair, pair, st.floats(0.4, 4.0))
def test_a_primitive_ends_at_rest_at_its_goal_and_its_control_points_enclose_it(
    place: tuple[float, float], speed: tuple[float, float], change: tuple[float, float], goal: tuple[float, float], lasts: float
) -> None:
    durations = np.array([lasts])
    powers = to_rest(np.array(place), np.array(speed), np.array(change), np.array([goal]), durations)
    found = Primitive(3.0, lasts, powers[:, 0, 0])
    assert found.at(3.0) == pytest.approx(place, abs=1e-9)
    assert found.at(3.0, 1) == pytest.approx(speed, abs=1e-9)
    assert found.at(3.0, 2) == pytest.approx(change, abs=1e-9)
    last = found.duration_s ** np.arange(6) @ found.powers
    assert last == pytest.approx(goal, abs=1e-8)
    assert lasts ** np.arange(5) @ derived(found.powers, 1) == pytest.approx((0.0, 0.0), abs=1e-7)
    points = control_points(powers, durations)[:, 0, 0]
    for angle in (0.0, 1.0, 2.0, 4.0):
        direction = np.array((math.cos(angle), math.sin(angle)))
        path = np.array([found.at(3.0 + share * lasts) for share in np.linspace(0.0, 1.0, 30)])
        assert (path @ direction).max() <= (points @ direction).max() + 1e-6


def test_vehicles_with_jerk_encircle_within_their_limits_and_keep_clear() -> None:
    team = [pursuer(vehicle="triple-integrator", limits=HEAVY) for _ in RING]
    places, velocities, accelerations = np.array(RING) * 1.2, np.zeros((4, 2)), np.zeros((4, 2))
    clearance, separation, captured, sources = math.inf, math.inf, False, set()
    for tick in range(250):
        t_s = PERIOD_S * tick
        primitives = []
        for i, planner in enumerate(team):
            assert isinstance(planner, EncirclementPlanner)
            mates = [member(f"p{j}", t_s, places[j], tuple(velocities[j])) for j in range(4) if j != i]
            seen = observation(places[i], mates, EVADER, DISCS, t_s=t_s, velocity=tuple(velocities[i]))
            decision = planner.step(seen)
            sources.add(decision.diagnostics["primitive"])
            current = planner._primitives.current
            assert current is not None
            assert decision.velocity_ned_m_s[:2] == pytest.approx(current.at(t_s + PERIOD_S, 1))
            primitives.append(current)
        before = places.copy()
        places = np.array([one.at(t_s + PERIOD_S) for one in primitives])
        velocities = np.array([one.at(t_s + PERIOD_S, 1) for one in primitives])
        accelerations = np.array([one.at(t_s + PERIOD_S, 2) for one in primitives])
        assert np.hypot(*velocities.T).max() <= HEAVY.speed_max_m_s + 1e-6
        assert np.hypot(*accelerations.T).max() <= HEAVY.acceleration_max_m_s2 + 1e-6
        clearance = min(clearance, least_gap(before, places))
        separation = min(separation, *(math.dist(places[i], places[j]) for i in range(4) for j in range(i)))
        captured = captured or bool(np.hypot(*(places - EVADER).T).min() <= 1.0)
    assert captured
    assert clearance >= RADIUS_M - 0.01
    assert separation >= 2 * RADIUS_M
    assert "new" in sources


def left_after_chase_m(**parameters: object) -> float:
    """How far behind an evader at 0.8 m/s a vehicle with jerk is that began 4 m behind it, after 20 s."""
    planner = pursuer(vehicle="triple-integrator", limits=HEAVY, **parameters)
    assert isinstance(planner, EncirclementPlanner)
    place, velocity, evader = np.zeros(2), np.zeros(2), np.array((4.0, 0.0))
    for tick in range(200):
        t_s = PERIOD_S * tick
        planner.step(observation(place, [], evader, t_s=t_s, velocity=tuple(velocity), evader_velocity=(0.8, 0.0)))
        current = planner._primitives.current
        assert current is not None
        place, velocity = current.at(t_s + PERIOD_S), current.at(t_s + PERIOD_S, 1)
        evader = evader + PERIOD_S * np.array((0.8, 0.0))
    return math.dist(place, evader)


def test_a_vehicle_with_jerk_keeps_up_with_an_evader_that_runs() -> None:
    assert left_after_chase_m() < 3.5
    assert left_after_chase_m(primitive_lead_s=0.0) > 6.0, "who would rest where the goal is now is left behind"


def test_a_velocity_loop_that_lags_is_commanded_ahead() -> None:
    def commanded(lag_s: float) -> tuple[np.ndarray, np.ndarray]:
        planner = pursuer(vehicle="triple-integrator", limits=HEAVY, primitive_lag_s=lag_s)
        decision = planner.step(observation((0.0, 0.0), [], (9.0, 0.0)))
        assert decision.acceleration_ned_m_s2 is not None
        return decision.velocity_ned_m_s, decision.acceleration_ned_m_s2

    velocity, acceleration = commanded(0.0)
    assert commanded(0.2)[0] == pytest.approx(velocity + 0.2 * acceleration)


def test_multirotors_that_answer_late_keep_clear_at_full_speed() -> None:
    assert least_lagged_gap() > 0.2
    assert least_lagged_gap(response_lag_s=0.0, reaction_s=0.0) < 0.1, "those who do not know their lag eat up the margin"


def least_lagged_gap(**parameters: object) -> float:
    """Least distance of two bodies with a velocity lag from discs, while the evader that they follow jumps about."""
    fast = Limits(6.0, 6.0, 60.0, 3.0, 12.0, 2.0, 0.25, 0.25)
    random = np.random.default_rng(6)
    contact = {"radius_m": 0.6, "mode": "first"}
    team = [pursuer(limits=fast, vehicle="multirotor", capture=contact, **parameters) for _ in range(2)]
    discs = [(n + 2.0 * (k % 2), e, 0.8) for k, n in enumerate((-8.0, -4.0, 0.0, 4.0, 8.0)) for e in (-8.0, -4.0, 0.0, 4.0, 8.0)]
    places, velocities, least = np.array([(-6.0, -6.0), (6.0, 6.0)]), np.zeros((2, 2)), math.inf
    evader = np.zeros(2)
    for tick in range(300):
        if tick % 15 == 0:
            evader = random.uniform(-9.0, 9.0, 2)
        for i, planner in enumerate(team):
            mate = member("mate", 0.1 * tick, places[1 - i], tuple(velocities[1 - i]))
            seen = observation(places[i], [mate], evader, discs, t_s=0.1 * tick, velocity=tuple(velocities[i]))
            wanted = planner.step(seen).velocity_ned_m_s[:2]
            for _ in range(5):
                change = (wanted - velocities[i]) / 0.45
                change *= min(1.0, 7.0 / max(float(np.hypot(*change)), 1e-9))
                velocities[i] += 0.02 * change
                places[i] += 0.02 * velocities[i]
                least = min([least, *(math.dist(places[i], disc[:2]) - disc[2] - fast.body_radius_m for disc in discs)])
    return least

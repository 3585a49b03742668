"""Whole chases: nobody touches anything, evaders are encircled and caught, from every start that the paper's method fails at."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from flightapp.planning.encirclement import situation
from flightapp.planning.encirclement.situation import DISC_SHARE, Looking
from flightapp.planning.geometry.half_planes import add_rounds
from flightapp.planning.registry import ENCIRCLEMENT, make_evader
from tests.planning.encirclement.arena import GIVEN, LIMITS, RADIUS_M, Chase, Evading, chase, fleeing, observation, pursuer

Place = tuple[float, float]


def drawn(
    seed: int, pursuers: int, discs: int, half_m: float = 6.0
) -> tuple[list[Place], Place, list[tuple[float, float, float]]]:
    """Starts that are free, and discs with room between them."""
    random = np.random.default_rng(seed)
    obstacles: list[tuple[float, float, float]] = []
    while len(obstacles) < discs:
        n, e, radius = *random.uniform(-half_m, half_m, 2), random.uniform(0.3, 0.8)
        if all(math.dist((n, e), other[:2]) > radius + other[2] + 0.8 for other in obstacles):
            obstacles.append((n, e, radius))
    starts: list[Place] = []
    while len(starts) <= pursuers:
        n, e = random.uniform(-half_m, half_m, 2)
        free = all(math.dist((n, e), disc[:2]) > disc[2] + 0.4 for disc in obstacles)
        if free and all(math.dist((n, e), other) > 1.3 for other in starts):
            starts.append((n, e))
    return starts[:-1], starts[-1], obstacles


def jumping(seed: int) -> Evading:
    """Anywhere, a new way every period: also into walls and into pursuers."""
    random = np.random.default_rng(seed)
    return lambda t_s, own, pursuers: 0.9 * random.uniform(-1.0, 1.0, 2)


def separation_with_delay(seed: int) -> float:
    """Least distance in a tight crowd in which everybody sees where the others were 0.1 s ago."""
    places = [(-1.0, 0.0), (-0.5, 0.9), (0.5, 0.9), (1.0, 0.0), (0.5, -0.9), (-0.5, -0.9), (0.0, 1.9)]
    found = chase(places, (0.0, 0.0), evading=jumping(seed), seconds=4.0, delay_periods=1, stops=False, box_half_min_m=0.2)
    return found.separation_m


@pytest.mark.parametrize("method", ENCIRCLEMENT)
def test_nobody_ever_touches_anything(method: str) -> None:
    for seed in (1, 2):
        starts, evader, discs = drawn(seed, 5, 8)
        found = chase(starts, evader, discs, evading=jumping(seed), method=method, seconds=6.0, stops=False)
        assert found.clearance_m >= RADIUS_M - 1e-9
        assert found.separation_m >= 2.0 * RADIUS_M - 1e-9
        assert found.clearance_m < 1.0, "obstacles were in the way"
        assert all("violation" not in decision.diagnostics["flags"] for row in found.decisions for decision in row)


def test_nobody_touches_anybody_by_old_positions(monkeypatch: pytest.MonkeyPatch) -> None:
    assert min(separation_with_delay(seed) for seed in range(3)) >= 2.0 * RADIUS_M - 1e-9
    monkeypatch.setattr(Looking, "_uncertain_m", lambda looking, mate: 0.0)
    assert min(separation_with_delay(seed) for seed in range(3)) < 2.0 * RADIUS_M - 1e-3, "without the inflation they do"


def test_an_evader_is_encircled_then_caught_in_the_forest() -> None:
    starts, evader, discs = drawn(11, 7, 16, half_m=10.0)
    found = chase(starts, evader, discs, evading=fleeing(0.5))
    assert found.captured_s is not None
    assert found.encircled_s is not None
    modes = [row[0].mode for row in found.decisions]
    assert modes.index("capture") > 0
    assert "encircle" not in modes[modes.index("capture") :], "latched"
    for row in found.decisions:
        sizes = np.array([decision.diagnostics["box_half_m"] for decision in row])
        assert np.ptp(sizes, axis=0).max() < 1e-9, "everybody computes the same box, without a leader"
    areas = [float(row[0].diagnostics["evader_area_m2"]) for row in found.decisions]
    assert areas[-1] < 0.1 * areas[0], "it has ever less room"
    reasons = [row[0].reason for row in found.decisions if row[0].reason]
    assert reasons[0] == "the evader is not encircled"


def test_the_papers_evader_is_caught_too() -> None:
    policy = make_evader(
        "voronoi-centroid",
        limits=LIMITS,
        parameters={
            "area_m": [-10.0, -10.0, 10.0, 10.0],
            "boundary_bias": 0.0,
            "settling_s": 0.1,
            "pursuer_distance_m": 0.0,
            "reaction_s": 0.0,
        },
    )

    def evading(t_s: float, own: np.ndarray, pursuers: np.ndarray) -> np.ndarray:
        velocity = policy.step(observation(own, list(pursuers), t_s=t_s)).velocity_ned_m_s[:2]
        return np.asarray(0.9 * velocity)

    starts, evader, _ = drawn(5, 5, 0)
    assert chase(starts, evader, evading=evading).captured_s is not None


def test_one_sided_and_level_starts_need_the_square_box() -> None:
    bunched = [(-8.0, -0.4), (-7.3, -0.4), (-8.0, 0.4), (-7.3, 0.4)]
    square, rect = chase(bunched, (0.0, 0.0)), chase(bunched, (0.0, 0.0), box="rect")
    assert square.encircled_s is not None
    assert square.captured_s is not None
    assert square.encircled_s < square.captured_s
    assert rect.encircled_s is None
    level = [(-6.0, 0.0), (-5.0, 0.0), (5.0, 0.0), (7.0, 0.0)]
    assert chase(level, (0.0, 0.0)).encircled_s is not None


def test_a_wall_and_a_bay_hold_them_up_only_without_a_way_around() -> None:
    wall = [[[-4.0, -0.2], [4.0, -0.2], [4.0, 0.2], [-4.0, 0.2]]]
    starts = [(0.0, -4.0), (0.8, -4.0), (-0.8, -4.0)]

    def flown(deadlock: bool) -> Chase:
        return chase(starts, (0.0, 3.0), polygons_m=wall, deadlock=deadlock, seconds=25.0)

    assert flown(deadlock=False).captured_s is None
    around = flown(deadlock=True)
    assert around.captured_s is not None
    assert "guided" in {decision.diagnostics["guidance"] for row in around.decisions for decision in row}


def test_the_box_is_latched_by_what_a_teammate_says_and_then_only_shrinks() -> None:
    planner = pursuer()
    sizes = []
    for tick in range(30):
        mates = [(6.0, 1.0), (5.0, -2.0)] if tick < 10 else [(4.0, 0.5), (4.0, -0.5)]
        seen = observation((5.0, 0.0), mates, (0.0, 0.0), t_s=0.1 * tick)
        if tick == 12:
            seen = replace(seen, team=(replace(seen.team[0], mode="capture"), seen.team[1]))
        sizes.append(planner.step(seen).diagnostics["box_half_m"][0])
    assert sizes[:10] == pytest.approx([6.0] * 10)
    assert sizes[10:13] == pytest.approx([5.0] * 3)
    assert np.diff(sizes[12:]) == pytest.approx(-0.1, abs=1e-9)


def test_the_box_shrinks_by_a_share_of_what_a_pursuer_flies_where_asked() -> None:
    def after(**parameters: object) -> float:
        planner = pursuer(**parameters)
        ring = [(0.0, 5.0), (-5.0, -5.0)]
        for tick in range(11):
            decision = planner.step(observation((5.0, 0.0), ring, (0.0, 0.0), t_s=0.1 * tick))
        return float(decision.diagnostics["box_half_m"][0])

    assert (after(), after(shrink_share=0.5)) == pytest.approx((4.0, 4.5))


@pytest.mark.parametrize("shrink", ["latch", "reopen", "eq8"])
def test_after_an_escape_the_box_reopens_only_where_asked(shrink: str) -> None:
    planner = pursuer(shrink=shrink)
    ring = [(0.0, 5.0), (-5.0, -5.0)]
    for tick in range(20):
        held = planner.step(observation((5.0, 0.0), ring, (0.0, 0.0), t_s=0.1 * tick)).diagnostics["box_half_m"][0]
    for tick in range(20, 40):
        decision = planner.step(observation((5.0, 0.0), ring, (-15.0, 0.0), t_s=0.1 * tick))
    size = decision.diagnostics["box_half_m"][0]
    assert held == pytest.approx(5.0 if shrink == "eq8" else 3.1)
    assert size == pytest.approx({"latch": 1.1, "reopen": 20.0, "eq8": 20.0}[shrink])
    assert decision.mode == ("encircle" if shrink == "reopen" else "capture")


def test_the_same_observations_give_the_same_decisions() -> None:
    def flown() -> list[list[float]]:
        starts, evader, discs = drawn(3, 4, 6)
        found = chase(starts, evader, discs, evading=jumping(3), seconds=3.0, stops=False)
        return [row[1].velocity_ned_m_s.tolist() for row in found.decisions]

    assert flown() == flown()


def test_at_the_goal_it_stands_without_chatter() -> None:
    ring = [(3.0 * math.cos(k * math.tau / 5), 3.0 * math.sin(k * math.tau / 5)) for k in range(5)]
    found = chase(ring, (0.0, 0.0), seconds=12.0, stops=False)
    last = np.array([decision.velocity_ned_m_s for row in found.decisions[-10:] for decision in row])
    assert np.abs(last).max() < 1e-3
    assert GIVEN["vehicle"] == "single-integrator"


def test_pursuers_stay_in_their_area() -> None:
    area = [-3.0, -3.0, 3.0, 3.0]
    found = chase(
        [(-2.0, -2.0), (2.0, -2.0), (0.0, 2.5)], (0.0, 5.0), evading=jumping(1), seconds=8.0, flight_area_m=area, stops=False
    )
    assert np.abs(np.array(found.places)[:, :-1]).max() <= 3.0 + 1e-9
    assert np.array(found.places)[-1, :-1, 1].max() > 2.9, "as near to the evader as they may"


def test_where_there_is_no_way_at_all_they_slide_and_stay_safe() -> None:
    ring = [(3.0 * math.cos(k * math.tau / 24), 3.0 * math.sin(k * math.tau / 24), 0.45) for k in range(24)]
    found = chase([(0.5, 0.0), (-0.5, 0.8), (-0.5, -0.8)], (9.0, 0.0), ring, seconds=14.0)
    assert found.captured_s is None
    assert found.clearance_m >= RADIUS_M - 1e-9
    assert "sliding" in {decision.diagnostics["guidance"] for row in found.decisions for decision in row}


def test_the_papers_printed_buffer_which_is_no_length_would_let_them_too_near(monkeypatch: pytest.MonkeyPatch) -> None:
    def literally(own_n: float, own_e: float, rounds: np.ndarray, count: int, planes: np.ndarray, filled: int) -> int:
        rows = rounds.copy()
        discs = rows[:, 3] == DISC_SHARE
        surface = rows[:, 2] - RADIUS_M
        gap = np.hypot(rows[:, 0] - own_n, rows[:, 1] - own_e) - surface
        rows[discs, 2] = (surface + RADIUS_M * gap)[discs]
        return add_rounds(own_n, own_e, rows, count, planes, filled)

    behind = ([(-3.0, 0.0), (-3.0, 1.0)], (3.0, 0.0), [(0.0, 0.0, 1.0)])
    assert chase(*behind, method="greedy", seconds=6.0, deadlock=False).clearance_m == pytest.approx(RADIUS_M)
    monkeypatch.setattr(situation, "add_rounds", literally)
    assert chase(*behind, method="greedy", seconds=6.0, deadlock=False).clearance_m < 0.05


def test_what_is_left_to_the_evader_is_its_cell_in_the_box() -> None:
    ring = [(0.0, 4.0), (-4.0, 0.0), (0.0, -4.0)]
    free = pursuer().step(observation((4.0, 0.0), ring, (0.0, 0.0))).diagnostics
    assert free["box_half_m"] == [4.0, 4.0]
    assert free["evader_area_m2"] == pytest.approx(16.0), "the square half way to each of four"
    beside = pursuer().step(observation((4.0, 0.0), ring, (0.0, 0.0), [(1.65, 0.0, 0.5)])).diagnostics
    assert beside["evader_area_m2"] == pytest.approx(12.0), "and not beyond an obstacle"

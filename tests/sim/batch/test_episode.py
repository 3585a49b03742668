"""Whole episodes: the same bits again, the same world for every planner, and links and sights that are felt."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from flightapp.core.errors import InputError
from flightapp.core.types import Decision, Observation
from flightapp.sim.batch import RunResult, Truth, fly, lay_out
from tests.sim.batch.stubs import scenario

SHORT = {"time_limit_s": 3.0}
TIMES = ("decision_ns", "sim_wall_ns")


class Kept:
    """A watcher that keeps everything."""

    def __init__(self) -> None:
        self.t_s: list[float] = []
        self.observations: list[list[Observation]] = []
        self.decisions: list[list[Decision]] = []
        self.truth: list[Truth] = []

    def step(self, t_s: float, observations: list[Observation], decisions: list[Decision], truth: Truth) -> None:
        self.t_s.append(t_s)
        self.observations.append(observations)
        self.decisions.append(decisions)
        self.truth.append(truth)

    def end(self, truth: Truth) -> None:
        self.last = truth


def test_the_watcher_sees_the_contact_that_ends_the_episode() -> None:
    flown = scenario()
    kept = Kept()
    result = fly(flown, "ac2f", 7, watcher=kept)
    *pursuers, evader = (state.position_ned_m for state in kept.last.states)
    assert result.outcome == "captured"
    assert kept.last.states[0].t_s == result.duration_s
    assert min(np.linalg.norm(pursuer - evader) for pursuer in pursuers) == pytest.approx(flown.capture.radius_m, abs=1e-6)


def bits(result: RunResult) -> dict[str, object]:
    return {field.name: getattr(result, field.name) for field in dataclasses.fields(result) if field.name not in TIMES}


@pytest.mark.parametrize("name", ["a2-dense-d435", "a2-encircle", "a3-terminal"])
def test_an_episode_flown_again_is_the_same_to_the_last_bit(name: str) -> None:
    flown = scenario(name, time_limit_s=6.0)
    once, again = fly(flown, "ac2f", 7), fly(flown, "ac2f", 7, watcher=Kept())
    assert bits(once) == bits(again)
    assert bits(once) != bits(fly(flown, "ac2f", 8))
    periods = math.ceil(once.duration_s / flown.control_period_s - 1e-9)
    assert len(once.decision_ns) == periods
    assert once.decisions == flown.pursuers.count * periods
    assert sum(once.mode_share.values()) == pytest.approx(1.0)


def test_dense_scenario_is_won_and_the_result_says_how() -> None:
    result = fly(scenario(layout__discs=0), "ac2f", 3)
    assert result.outcome == "captured"
    assert result.capture_time_s == result.duration_s
    assert 5.0 < result.duration_s < 20.0
    assert 0.5 * 6.0 * result.duration_s < result.path_length_m <= 6.0 * result.duration_s
    assert 0.0 < result.boundary_distance_m < 60.0
    assert math.isinf(result.min_clearance_m)
    assert result.mean_jerk_m_s3 > 0.0


def test_evader_that_nobody_can_catch_escapes() -> None:
    fast = scenario(evader__speed_max_m_s=8.0, layout__discs=0)
    result = fly(fast, "ac2f", 3)
    assert (result.outcome, result.boundary_distance_m, result.capture_time_s) == ("escaped", 0.0, None)


def test_planners_meet_the_same_world_and_the_same_evader() -> None:
    flown = scenario(**SHORT)
    first, second = Kept(), Kept()
    fly(flown, "ac2f", 11, watcher=first)
    fly(flown, "ac2f", 11, {"fine_distance_m": 9.0, "field_gain_m2": 1.0}, watcher=second)
    assert (first.truth[0].layout.discs == second.truth[0].layout.discs).all()
    for a, b in zip(first.truth, second.truth, strict=True):
        assert (a.states[-1].position_ned_m == b.states[-1].position_ned_m).all()


def test_late_messages_are_felt_and_their_age_is_honest() -> None:
    kept = Kept()
    fly(scenario(messages__delay_s=0.25, **SHORT), "ac2f", 2, watcher=kept)
    for tick, observations in enumerate(kept.observations):
        mate = observations[0].team[0]
        assert mate.name == "p2"
        assert mate.age_s == pytest.approx(0.3)
        then = kept.truth[max(0, tick - 3)].states[1]
        np.testing.assert_allclose(mate.state.position_ned_m, then.position_ned_m + 0.3 * then.velocity_ned_m_s)


def test_lost_messages_are_felt() -> None:
    kept = Kept()
    fly(scenario(messages__loss_probability=0.5, **SHORT), "ac2f", 2, watcher=kept)
    ages = [observations[i].team[0].age_s for observations in kept.observations for i in (0, 1)]
    assert 0.3 < np.mean([age > 0.05 for age in ages]) < 0.7
    assert max(ages) > 0.15


def test_ideal_knowledge_is_the_truth() -> None:
    kept = Kept()
    fly(scenario(**SHORT), "ac2f", 2, watcher=kept)
    for observations, truth in zip(kept.observations, kept.truth, strict=True):
        target = observations[0].target
        assert target is not None
        assert target.age_s == 0.0
        assert (target.position_ned_m == truth.states[-1].position_ned_m).all()
        assert (observations[0].team[0].state.position_ned_m == truth.states[1].position_ned_m).all()
        assert len(observations[-1].team) == 2


@pytest.mark.parametrize("filtered", [False, True])
def test_noisy_late_target_is_near_the_truth_and_stamped_with_its_time(filtered: bool) -> None:
    kept = Kept()
    noisy = scenario(
        target__position_noise_m=0.2, target__velocity_noise_m_s=0.2, target__latency_s=0.06, target__filter=filtered, **SHORT
    )
    fly(noisy, "ac2f", 2, watcher=kept)
    errors = []
    for t_s, observations, truth in zip(kept.t_s[5:], kept.observations[5:], kept.truth[5:], strict=True):
        target = observations[0].target
        assert target is not None
        assert target.age_s == pytest.approx(0.06)
        ahead = target.position_ned_m + (t_s - target.t_s) * target.velocity_ned_m_s
        errors.append(math.dist(ahead[:2], truth.states[-1].position_ned_m[:2]))
    assert 0.02 < np.mean(errors) < 0.4


def test_target_behind_obstacles_grows_old() -> None:
    """Inside the trap there is no line of sight to the evader; the first measurement never comes."""
    kept = Kept()
    fly(scenario("a1-u-trap", target__needs_sight=True, time_limit_s=1.0), "ac2f", 2, watcher=kept)
    assert all(observations[0].target is None for observations in kept.observations)


def test_moving_obstacles_are_seen_to_move() -> None:
    kept = Kept()
    fly(scenario(layout__moving_discs=20, sensing__range_m=100.0, **SHORT), "ac2f", 4, watcher=kept)
    first, later = kept.observations[0][0].obstacles.discs, kept.observations[10][0].obstacles.discs
    np.testing.assert_allclose(np.hypot(first[:, 3], first[:, 4]), 1.0)
    moved = np.hypot(*(later[:, :2] - first[:, :2]).T)
    assert (moved <= 1.0 + 1e-9).all()
    assert (moved > 0.99).sum() > 10


def test_unknown_names_are_refused_in_one_sentence() -> None:
    with pytest.raises(InputError, match="no such pursuer strategy"):
        fly(scenario(), "nobody", 1)
    with pytest.raises(InputError, match="no such evader policy"):
        fly(scenario(evader__policy="nobody"), "ac2f", 1)
    with pytest.raises(InputError, match=r"layout\.pursuer_starts_m: 2 starts for pursuers\.count = 3"):
        lay_out(scenario(pursuers__count=3), 1)

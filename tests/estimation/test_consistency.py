"""The target filter on a recorded race: its covariance tells the truth, and vehicles that hear differently agree within it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.errors import InputError
from flightapp.core.types import TargetTrack
from flightapp.estimation.consistency import CONSTANT_VELOCITY, Circumstances, Flight, judge, measurements_of, read_flight
from flightapp.estimation.target_filter import TargetFilter

RACE = Path(__file__).parent / "data" / "fpv_race_10hz.csv"


@pytest.fixture(scope="module")
def race() -> Flight:
    return read_flight(RACE)


def test_on_a_race_with_loss_delay_and_occlusions_the_errors_are_as_large_as_the_covariance_says(race: Flight) -> None:
    """One straight model is far too sure of itself there; all models together are consistent and nearer to the truth."""
    for seed in (0, 1):
        straight = judge(race, CONSTANT_VELOCITY, seed=seed)
        mixed = judge(race, seed=seed)
        low, high = mixed.nees_bounds
        assert straight.nees > high
        assert 0.75 * low < mixed.nees < high
        assert mixed.inside > 0.9
        assert 0.7 < mixed.nis < 1.2
        assert mixed.position_rms_m < 0.8 * straight.position_rms_m
        assert mixed.velocity_rms_m_s < 0.8 * straight.velocity_rms_m_s
        assert all(mixed_m < straight_m for mixed_m, straight_m in zip(mixed.ahead_rms_m, straight.ahead_rms_m, strict=True))


def test_of_a_tame_evader_the_filter_is_not_too_sure_either() -> None:
    slow = judge(read_flight(RACE, slowed=3.0))
    assert slow.nees < slow.nees_bounds[1]
    assert slow.inside > 0.95
    assert slow.inside_hidden > 0.95
    assert slow.position_rms_m < 0.6


def test_through_an_occlusion_the_covariance_grows_as_the_error_does(race: Flight) -> None:
    """Nothing for up to 1.5 s from any moment of the race: errors mostly stay inside the ellipsoid, which grows all the time.

    Nobody foretells a racing pilot's turns of 20 m/s2 over 1.5 s; one straight model is right of one in four then.
    """
    arrivals = measurements_of(race, replace(Circumstances(), delay_max_s=0.02), (), np.random.default_rng(2))
    arrivals.sort(key=lambda pair: pair[0])
    target, inside, due_s = TargetFilter(), [], 2.0
    for arrived_s, measurement in arrivals:
        if arrived_s >= due_s:
            due_s += 0.25
            tracks = [target.predict(arrived_s + ahead_s) for ahead_s in (0.0, 0.5, 1.0, 1.5)]
            spreads = [np.trace(track.covariance[:3, :3]) for track in tracks if track is not None]
            assert len(spreads) == 4
            assert (np.diff(spreads) > 0.0).all()
            if arrived_s + 1.5 < race.duration_s:
                inside.append([_nees(track, race) < 12.59 for track in tracks])
        target.take(measurement)
    shares = np.mean(inside, axis=0)
    assert len(inside) > 50
    assert shares[0] > 0.9
    assert shares[1] > 0.75
    assert shares[3] > 0.55


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_who_hears_the_same_believes_the_same(seed: int) -> None:
    """The same measurements in two orders, none later than the ring reaches: the same numbers, to the last bit."""
    random = np.random.default_rng(seed)
    arrivals = measurements_of(read_flight(RACE), Circumstances(), (), random)
    window = [measurement for _, measurement in sorted(arrivals) if 3.0 <= measurement.t_s < 4.2]
    orders = [window, [window[place] for place in random.permutation(len(window))]]
    assert orders[0] != orders[1]
    tracks = []
    for order in orders:
        target = TargetFilter()
        for measurement in order:
            target.take(measurement)
        tracks.append(target.predict(4.5))
    one, two = tracks
    assert one is not None
    assert two is not None
    assert np.array_equal(one.position_ned_m, two.position_ned_m)
    assert np.array_equal(one.velocity_ned_m_s, two.velocity_ned_m_s)
    assert np.array_equal(one.covariance, two.covariance)


def test_who_loses_different_messages_agrees_within_the_covariances(race: Flight) -> None:
    """Two vehicles lose 20 % each, independently, with delays of their own; compared at every control period."""
    random = np.random.default_rng(11)
    sent = measurements_of(race, replace(Circumstances(), loss=0.0), (), random)
    heard = [
        sorted((measurement.t_s + random.uniform(0.02, 0.3), measurement) for _, measurement in sent if random.random() > 0.2)
        for _ in range(2)
    ]
    assert heard[0] != heard[1]
    targets = [TargetFilter(), TargetFilter()]
    apart = []
    for tick in range(50, int(race.duration_s * 25)):
        now_s = tick * 0.04
        tracks = []
        for target, queue in zip(targets, heard, strict=True):
            while queue and queue[0][0] <= now_s:
                target.take(queue.pop(0)[1])
            tracks.append(target.predict(now_s))
        one, two = tracks
        assert one is not None
        assert two is not None
        offset = np.concatenate((one.position_ned_m - two.position_ned_m, one.velocity_ned_m_s - two.velocity_ned_m_s))
        assert np.isfinite(offset).all()
        apart.append(float(offset @ np.linalg.solve(one.covariance + two.covariance, offset)))
    assert max(apart) > 0.0
    assert np.mean(np.array(apart) < 12.59) > 0.99


@pytest.mark.parametrize(
    ("text", "words"),
    [("timestamp,tx,ty,tz\n0,1,2,3\n", "at least 20"), ("timestamp,tx,ty,tz\n0,a,2,3\n", "timestamp,x,y,z")],
)
def test_a_file_that_is_no_flight_is_refused_in_one_sentence(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "track.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=words):
        read_flight(path)
    with pytest.raises(InputError, match="cannot be read"):
        read_flight(tmp_path / "none.csv")


def _nees(track: TargetTrack | None, race: Flight) -> float:
    assert track is not None
    error = np.concatenate((track.position_ned_m, track.velocity_ned_m_s)) - race.truth(track.t_s)
    return float(error @ np.linalg.solve(track.covariance, error))

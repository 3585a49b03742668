"""Tracking of what an ideal extraction hands over: association, velocity, memory, exclusions, time."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from perception.parameters import PerceptionParameters
from perception.sighting import Sighting
from perception.tracking.tracker import TRACKS_MAX, DiscTracker, TrackedDiscs
from tests.perception.sightings import NO_DISCS, Lookout

POLE = np.array([[4.0, 0.0, 0.2]])
NOISE_1_M = 0.004
"""Depth noise of a D435, and of every disc as if it were one pixel."""
DISC_NOISE_1_M = 0.0015
"""What is left of it in the mean over a disc's pixels, which are noisy in blobs."""


def tracker(**changes: object) -> DiscTracker:
    return DiscTracker(PerceptionParameters(**changes))


def speeds(found: TrackedDiscs) -> np.ndarray:
    return np.hypot(found.discs[:, 3], found.discs[:, 4])


def nearest(found: TrackedDiscs, north: float, east: float) -> tuple[int, float]:
    """Index of the disc closest to a place, and how far it is from there."""
    gap = np.hypot(found.discs[:, 0] - north, found.discs[:, 1] - east)
    return int(gap.argmin()), float(gap.min())


def test_a_disc_seen_once_is_reported_and_believed_more_when_seen_again() -> None:
    known, camera = tracker(), Lookout()
    confidence = []
    for frame in range(4):
        found = known.update(frame / 30, camera.look(POLE), NO_DISCS)
        assert found.discs[0] == pytest.approx([4.0, 0.0, 0.2, 0.0, 0.0], abs=0.03)
        confidence.append(float(found.confidence[0]))
    assert confidence[0] == pytest.approx(0.5)
    assert confidence == sorted(set(confidence))
    assert confidence[-1] > 0.9


@pytest.mark.parametrize("rate_hz", [15, 30, 90])
def test_a_pole_is_one_disc_at_one_place_over_several_turns(rate_hz: int) -> None:
    known, camera = tracker(memory_s=4.0), Lookout(noise=DISC_NOISE_1_M, seed=rate_hz)
    posts = np.array([[4.0, 0.0, 0.15], [0.0, 5.0, 0.3], [-3.0, -1.0, 0.2], [-5.0, 2.0, 0.5], [1.0, -6.0, 0.4]])
    places, counts = [], []
    for frame in range(int(5 * math.pi * rate_hz)):
        t_s = frame / rate_hz
        error = math.radians(1.0) * math.sin(3.0 * t_s)
        found = known.update(t_s, camera.look(posts, yaw=2.0 * t_s, yaw_error_rad=error), NO_DISCS)
        assert not speeds(found).any()
        for north, east in found.discs[:, :2]:
            gap = np.hypot(posts[:, 0] - north, posts[:, 1] - east) - posts[:, 2]
            assert gap.min() < 0.15 + 2 * DISC_NOISE_1_M * 6.0**2
        counts.append(len(found.discs))
        places.append(found.discs[nearest(found, 4.0, 0.0)[0], :2] if len(found.discs) else [4.0, 0.0])
    # At the edge of the picture the first glimpse of a tree may lie beside what is known of it.
    assert max(counts) <= len(posts) + 1
    assert np.mean(np.array(counts) > len(posts)) < 0.05
    later = np.array(places[int(math.pi * rate_hz) :])
    assert np.hypot(later[:, 0] - 4.0, later[:, 1]).max() < 0.15 + 2 * DISC_NOISE_1_M * 4.0**2


@pytest.mark.parametrize("rate_hz", [30, 90])
def test_what_stands_still_is_given_a_velocity_in_less_than_a_thousandth_of_its_frames(rate_hz: int) -> None:
    """A wood at 8 m/s, looking to both sides at up to 2 rad/s, with 1 degree of attitude error and D435 noise."""
    reported = false = 0
    for seed in range(6 if rate_hz == 30 else 2):
        random = np.random.default_rng(seed)
        trees = np.column_stack([random.uniform(-5, 50, 50), random.uniform(-12, 12, 50), random.uniform(0.1, 0.6, 50)])
        trees = trees[np.abs(trees[:, 1]) > 1.0]
        frequency_hz, phase = random.uniform(0.2, 3.0), random.uniform(0, math.tau)
        known, camera = tracker(), Lookout(noise=NOISE_1_M, seed=seed)
        for frame in range(5 * rate_hz):
            t_s = frame / rate_hz
            error = math.radians(1.0) * math.sin(math.tau * frequency_hz * t_s + phase)
            sighting = camera.look(trees, north=8.0 * t_s, yaw=math.sin(2.0 * t_s), yaw_error_rad=error)
            found = known.update(t_s, sighting, NO_DISCS)
            reported += len(found.discs)
            false += np.count_nonzero(speeds(found))
    assert reported > 5000
    assert false < reported / 1000


@pytest.mark.parametrize(("speed_m_s", "radius_m", "start_m"), [(1.5, 0.25, -1.0), (5.0, 0.35, -2.0)])
@pytest.mark.parametrize("rate_hz", [30, 90])
def test_a_crossing_person_or_drone_has_its_velocity_within_half_a_second(
    speed_m_s: float, radius_m: float, start_m: float, rate_hz: int
) -> None:
    errors = []
    for seed in range(10):
        known, camera = tracker(), Lookout(noise=NOISE_1_M, seed=seed)
        for frame in range(int(0.8 * rate_hz)):
            t_s = frame / rate_hz
            body = np.array([[4.0, start_m + speed_m_s * t_s, radius_m]])
            found = known.update(t_s, camera.look(body), NO_DISCS)
            assert len(found.discs) == 1
            if t_s >= 0.5:
                errors.append(float(np.hypot(found.discs[0, 3], found.discs[0, 4] - speed_m_s)))
    assert np.mean(errors) < 0.25
    assert np.mean(np.array(errors) < 0.5) > 0.95


def test_what_stops_loses_its_velocity() -> None:
    known, camera = tracker(), Lookout(noise=NOISE_1_M, seed=2)
    for frame in range(90):
        t_s = frame / 30
        found = known.update(t_s, camera.look(np.array([[4.0, -1.5 + 2.0 * min(t_s, 1.0), 0.25]])), NO_DISCS)
        if frame == 29:
            assert speeds(found) == pytest.approx([2.0], abs=0.5)
    assert speeds(found).tolist() == [0.0]


def test_pieces_that_slide_along_a_wall_have_no_velocity() -> None:
    known, view = tracker(), Lookout().look(NO_DISCS).view
    for frame in range(60):
        offset = frame / 30
        discs = np.array([[5.0, -2.0 + 0.7 * k + offset % 0.7, 0.5] for k in range(6)])
        pieces = Sighting(discs, np.full(6, 0.1), np.ones(6), np.zeros(6, np.bool_), view)
        found = known.update(frame / 30, pieces, NO_DISCS)
        assert not speeds(found).any()
        assert len(found.discs) <= 8
        for disc in discs:
            assert nearest(found, disc[0], disc[1])[1] < 1e-9


def test_what_moves_is_predicted_while_it_is_hidden() -> None:
    known, camera = tracker(memory_moving_s=1.5), Lookout(noise=0.001)
    screen = [3.0, 0.2, 0.6]
    for frame in range(75):
        t_s = frame / 30
        east = -2.5 + 2.0 * t_s
        found = known.update(t_s, camera.look(np.array([screen, [5.0, east, 0.25]])), NO_DISCS)
        hidden = abs(east / 5.0 - 0.2 / 3.0) < 0.15
        if t_s > 0.6:
            index, gap = nearest(found, 5.0, east)
            assert gap < 0.5, t_s
            assert found.discs[index, 4] == pytest.approx(2.0, abs=0.6)
            assert found.age_s[index] > 0 or not hidden
            assert len(found.discs) == 2


def test_memory_of_what_moves_ends_sooner_and_grows_faster() -> None:
    known, camera = tracker(memory_s=3.0, memory_moving_s=1.0, memory_growth_moving_m_s=0.5), Lookout()
    for frame in range(30):
        known.update(frame / 30, camera.look(np.array([[4.0, -1.5 + 2.0 * frame / 30, 0.3], [6.0, -4.0, 0.3]])), NO_DISCS)
    sizes = {}
    for frame in range(30, 90):
        found = known.update(frame / 30, None, NO_DISCS)
        sizes[frame] = found.discs[np.argsort(found.discs[:, 1]), 2].tolist()
    assert sizes[44] == pytest.approx([0.3 + 0.5 * 0.05, 0.3 + 0.5 * 0.5], abs=0.01)
    assert len(sizes[65]) == 1


def test_confidence_falls_with_age_and_ends_with_the_memory() -> None:
    known, camera = tracker(memory_s=1.0), Lookout()
    for frame in range(5):
        known.update(frame / 30, camera.look(POLE), NO_DISCS)
    confidence = [known.update((5 + frame) / 30, None, NO_DISCS).confidence.tolist() for frame in range(31)]
    assert all(later < before for before, later in itertools.pairwise(confidence[:30]))
    assert confidence[-1] == []


@pytest.mark.parametrize("hits", [1, 2, 30])
def test_only_what_is_seen_through_is_forgotten_early_and_what_is_well_known_not_at_once(hits: int) -> None:
    known, camera = tracker(), Lookout()
    for frame in range(hits):
        known.update(frame / 30, camera.look(POLE), NO_DISCS)
    counts = [len(known.update((hits + k) / 30, camera.look(NO_DISCS), NO_DISCS).discs) for k in range(20)]
    assert counts == [1] * 20, "no return is no evidence"
    camera.background_m = 8.0
    counts = [len(known.update((hits + 20 + k) / 30, camera.look(NO_DISCS), NO_DISCS).discs) for k in range(4)]
    assert counts.index(0) == min(hits, 3) - 1


def test_a_tree_cut_off_by_the_edge_of_the_picture_stays_whole() -> None:
    known, camera = tracker(), Lookout()
    tree = np.array([[4.0, 0.0, 0.6]])
    for frame in range(30):
        yaw = math.radians(50.0) * frame / 30
        found = known.update(frame / 30, camera.look(tree, yaw=yaw), NO_DISCS)
        assert len(found.discs) == 1
        assert found.discs[0, :3] == pytest.approx([4.0, 0.0, 0.6], abs=0.06)


def test_a_tree_that_comes_into_the_picture_is_one_disc_in_the_end() -> None:
    known, camera = tracker(), Lookout()
    tree = np.array([[4.0, 0.0, 0.6]])
    for frame in range(60):
        found = known.update(frame / 30, camera.look(tree, yaw=math.radians(55.0 - frame)), NO_DISCS)
        assert len(found.discs) <= 2
        assert not speeds(found).any()
    assert found.discs[:, :3].tolist() == [pytest.approx([4.0, 0.0, 0.6], abs=0.06)]


def test_nothing_is_reported_inside_an_exclusion_but_a_tree_outlives_it() -> None:
    known, camera = tracker(), Lookout()
    for frame in range(45):
        known.update(frame / 30, camera.look(POLE), NO_DISCS)
    circle = np.array([[4.0, 0.3, 0.8]])
    for frame in range(45, 60):
        assert len(known.update(frame / 30, camera.look(POLE), circle).discs) == 0
    assert nearest(known.update(2.0, None, NO_DISCS), 4.0, 0.0)[1] < 0.1


def test_a_teammate_leaves_no_trail_and_moves_once_its_position_is_no_longer_known() -> None:
    known, camera = tracker(), Lookout(noise=NOISE_1_M)
    post = [5.0, 1.0, 0.2]
    for frame in range(90):
        t_s = frame / 30
        east = -3.0 + 2.0 * t_s
        circle = np.array([[4.0, east, 0.8]]) if t_s < 1.5 else NO_DISCS
        found = known.update(t_s, camera.look(np.array([post, [4.0, east, 0.35]])), circle)
        others = np.hypot(found.discs[:, 0] - 5.0, found.discs[:, 1] - 1.0) > 0.4
        if t_s < 1.5:
            assert not others.any()
        if t_s > 2.0:
            assert np.count_nonzero(others) == 1
            assert found.discs[others, 4] == pytest.approx([2.0], abs=0.6)


def test_late_and_repeated_frames_are_used_for_nothing() -> None:
    known, camera = tracker(), Lookout()
    before = known.update(1.0, camera.look(POLE), NO_DISCS)
    for t_s in (1.0, 0.95, math.nan):
        after = known.update(t_s, camera.look(np.array([[6.0, 1.0, 0.3]])), NO_DISCS)
        assert after.discs.tolist() == before.discs.tolist()
        assert after.confidence.tolist() == before.confidence.tolist()


def test_a_clock_set_back_forgets_nothing() -> None:
    known, camera = tracker(), Lookout()
    known.update(1000.0, camera.look(POLE), NO_DISCS)
    known.update(1001.0, None, NO_DISCS)
    found = known.update(5.0, None, NO_DISCS)
    assert found.age_s == pytest.approx([1.0])
    assert len(known.update(6.5, camera.look(POLE, yaw=math.pi), NO_DISCS).discs) == 1
    assert len(known.update(7.5, None, NO_DISCS).discs) == 0


def test_after_a_gap_of_seconds_what_stands_is_the_same_disc_and_what_is_forgotten_is_gone() -> None:
    known, camera = tracker(memory_s=3.0), Lookout()
    for t_s in (0.0, 0.03, 2.5):
        found = known.update(t_s, camera.look(POLE), NO_DISCS)
    assert len(found.discs) == 1
    assert found.confidence[0] > 0.8
    assert len(known.update(9.0, None, NO_DISCS).discs) == 0


def test_no_memory_means_only_what_is_seen_now() -> None:
    known, camera = tracker(memory_s=0.0), Lookout(noise=NOISE_1_M)
    for frame in range(30):
        found = known.update(frame / 30, camera.look(np.array([[4.0, -1.0 + 2.0 * frame / 30, 0.3]])), NO_DISCS)
    assert speeds(found) == pytest.approx([2.0], abs=0.5)
    assert len(known.update(1.0, None, NO_DISCS).discs) == 0


def test_with_too_many_discs_the_nearest_and_newest_stay() -> None:
    known = tracker(memory_s=60.0)
    view = Lookout().look(NO_DISCS).view
    for frame in range(20):
        east = np.arange(100) * 3.0 + 300.0 * frame
        discs = np.column_stack([np.full(100, 5.0), east, np.full(100, 0.3)])
        found = known.update(frame / 30, Sighting(discs, np.full(100, 0.1), np.ones(100), np.ones(100, np.bool_), view), NO_DISCS)
        assert len(found.discs) <= TRACKS_MAX
        assert np.count_nonzero(found.age_s == 0.0) == 100
    crowd = np.column_stack([np.full(1000, 5.0), np.arange(1000) * 3.0, np.full(1000, 0.3)])
    found = known.update(1.0, Sighting(crowd, np.full(1000, 0.1), np.ones(1000), np.ones(1000, np.bool_), view), NO_DISCS)
    assert len(found.discs) == TRACKS_MAX
    assert found.discs[:, 1].max() == 3.0 * (TRACKS_MAX - 1)

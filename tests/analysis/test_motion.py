"""Figures of motion against values worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightapp.analysis import motion
from flightapp.analysis.track import Track
from flightapp.config.mission import Box, Cylinder, Obstacles
from flightapp.core.types import Array, Boundary
from flightapp.recording.phases import Window
from flightapp.sim.world import World


def track(t_s: list[float] | Array, position: list[list[float]] | Array, velocity: Array | None = None) -> Track:
    times, points = np.asarray(t_s, dtype=np.float64), np.asarray(position, dtype=np.float64)
    return Track("truth", times, points, np.zeros_like(points) if velocity is None else velocity)


def test_path_length_of_a_right_angle() -> None:
    assert motion.path_length_m(track([0, 1, 2], [[0, 0, -5], [3, 0, -5], [3, 4, -5]])) == pytest.approx(7.0)


@given(jerk=st.floats(0.1, 30.0), rate_hz=st.floats(20.0, 100.0))
def test_constant_jerk_is_found(jerk: float, rate_hz: float) -> None:
    times = np.arange(0.0, 4.0, 1.0 / rate_hz)
    velocity = np.column_stack([0.5 * jerk * times**2, np.full_like(times, 2.0), np.zeros_like(times)])
    flown = track(times, np.zeros((len(times), 3)), velocity)
    assert motion.mean_jerk_m_s3(flown) == pytest.approx(jerk, rel=0.03)


def test_a_straight_line_has_no_jerk_and_a_short_one_no_answer() -> None:
    times = np.arange(0.0, 4.0, 0.04)
    velocity = np.tile([3.0, 1.0, 0.0], (len(times), 1))
    assert motion.mean_jerk_m_s3(track(times, velocity * times[:, None], velocity)) == pytest.approx(0.0, abs=1e-9)
    assert motion.mean_jerk_m_s3(track(times[:10], velocity[:10], velocity[:10])) is None


def test_closest_approach_lies_between_the_samples() -> None:
    """Crossing at right angles: both are 0.3 m from the crossing's centre line only at t = 0.5, between samples."""
    first = track([0.0, 1.0], [[-5.0, 0.0, 0.0], [5.0, 0.0, 0.0]])
    second = track([0.0, 1.0], [[-5.0, 0.3, 0.0], [5.0, 0.3, 0.0]])
    parallel = motion.min_distance_m(first, second, Window(0.0, 1.0))
    assert parallel is not None
    assert parallel[0] == pytest.approx(0.3)
    crossing = track([0.1, 0.9], [[0.3, -4.0, 0.0], [0.3, 4.0, 0.0]])  # 10 m/s east, through (0.3, 0) at 0.5 s
    met = motion.min_distance_m(first, crossing, Window(0.0, 1.0))
    assert met is not None
    # relative position at 0.5 s is (0.3, 0), relative velocity (-10, 10): closest 0.3 / sqrt(2), 15 ms later
    assert met[0] == pytest.approx(0.3 / math.sqrt(2))
    assert met[1] == pytest.approx(0.515)


def test_closest_approach_outside_the_window_or_without_common_time_is_not_told() -> None:
    first = track([0.0, 1.0], [[0.0, 0.0, 0.0], [10.0, 0.0, 0.0]])
    meeting = track([0.0, 1.0], [[10.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    early = motion.min_distance_m(first, meeting, Window(0.0, 0.25))
    assert early is not None
    assert early[0] == pytest.approx(5.0)
    assert motion.min_distance_m(first, track([2.0, 3.0], [[0, 0, 0], [1, 0, 0]]), Window(0.0, 5.0)) is None


def test_clearance_between_two_samples_past_a_cylinder_and_a_box() -> None:
    world = World(
        Obstacles(
            cylinders=(Cylinder(north_m=5.0, east_m=1.5, radius_m=0.5, height_m=9.0),),
            boxes=(Box(north_m=12.0, east_m=-3.0, length_m=2.0, width_m=2.0, height_m=9.0),),
        )
    )
    flown = track([0.0, 10.0], [[0.0, 0.0, -5.0], [20.0, 0.0, -5.0]])
    assert motion.min_clearance_m(flown, world, 0.35) == pytest.approx(1.5 - 0.5 - 0.35, abs=0.011)
    shifted = track([0.0, 10.0], [[0.0, -1.5, -5.0], [20.0, -1.5, -5.0]])
    assert motion.min_clearance_m(shifted, world, 0.35) == pytest.approx(0.5 - 0.35, abs=0.011)
    through = track([0.0, 10.0], [[0.0, 1.5, -5.0], [20.0, 1.5, -5.0]])
    assert motion.min_clearance_m(through, world, 0.35) == pytest.approx(-0.5 - 0.35, abs=0.011)
    assert motion.min_clearance_m(flown, World(Obstacles()), 0.35) is None


def test_boundary_distance_to_a_line_and_to_a_closed_edge() -> None:
    points = np.array([[3.0, 0.0, -5.0], [-2.0, 4.0, -5.0], [0.0, 12.0, -5.0]])
    line = Boundary(np.array([[0.0, -10.0], [0.0, 10.0]]), closed=False)
    np.testing.assert_allclose(motion.boundary_distances_m(points, line), [3.0, 2.0, 2.0])
    square = Boundary(np.array([[-5.0, -5.0], [-5.0, 5.0], [5.0, 5.0], [5.0, -5.0]]), closed=True)
    np.testing.assert_allclose(motion.boundary_distances_m(points, square), [2.0, 1.0, 7.0])


def test_a_part_of_a_track_has_interpolated_ends() -> None:
    part = track([0.0, 1.0, 2.0], [[0, 0, 0], [1, 0, 0], [2, 0, 0]]).within(Window(0.5, 1.25))
    np.testing.assert_allclose(part.t_s, [0.5, 1.0, 1.25])
    np.testing.assert_allclose(part.position_ned_m[:, 0], [0.5, 1.0, 1.25])

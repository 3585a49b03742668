"""Avoidance inside the loop: the push, and the manoeuvre for what cannot be stopped before."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.control.avoidance import ACTIVE, EMERGENCY_SIZE, ENTRIES, AvoidanceGains, flee, push_away
from flightapp.space.distance import signed_distance_and_gradient
from flightapp.space.shapes import Cylinder, OrientedBox, bodies_of

GAINS = AvoidanceGains()
FLAT = GAINS.as_array()
BODIES = bodies_of(
    [
        Cylinder(20.0, 0.0, radius_m=3.0, top_down_m=-40.0, bottom_down_m=0.0),
        OrientedBox(0.0, 25.0, length_m=8.0, width_m=6.0, heading_rad=0.4, top_down_m=-40.0, bottom_down_m=0.0),
    ]
)
HEIGHT = -20.0


def test_what_is_left_behind_does_not_push_and_what_is_approached_does() -> None:
    push, place = np.zeros(3), np.array((13.0, 0.0, HEIGHT))
    push_away(FLAT, BODIES, place, np.array((-5.0, 0.0, 0.0)), push)
    assert not push.any()
    push_away(FLAT, BODIES, place, np.array((5.0, 0.0, 0.0)), push)
    assert push[0] < -1.0
    slow = np.zeros(3)
    push_away(FLAT, BODIES, place, np.array((0.5, 0.0, 0.0)), slow)
    assert push[0] < slow[0] <= 0.0, "the faster it closes in, the harder the push"


@settings(max_examples=60, deadline=None)
@given(st.floats(-5.0, 40.0), st.floats(-15.0, 40.0), st.floats(0.0, 12.0), st.floats(-math.pi, math.pi), st.floats(0.005, 0.1))
def test_the_manoeuvre_never_leads_towards_the_nearest_body(
    north: float, east: float, speed: float, course: float, dt_s: float
) -> None:
    place = np.array((north, east, HEIGHT))
    velocity = speed * np.array((math.cos(course), math.sin(course), 0.0))
    push, state = np.zeros(3), np.zeros(EMERGENCY_SIZE)
    for _ in range(10):
        if flee(FLAT, BODIES, state, place, velocity, 5.0, dt_s, push):
            _, *normal = signed_distance_and_gradient(BODIES, *place.tolist(), 0.0)
            assert float(push @ np.array(normal)) >= -1e-9
            assert np.linalg.norm(push) <= GAINS.acceleration_max_m_s2 * (1.0 + 1e-9)
        place = place + dt_s * velocity


def test_it_begins_off_the_way_only_and_ends_after_half_a_second_of_calm() -> None:
    push, state = np.zeros(3), np.zeros(EMERGENCY_SIZE)
    near, fast = np.array((10.0, 0.0, HEIGHT)), np.array((10.0, 0.0, 0.0))
    assert not flee(FLAT, BODIES, state, near, fast, 0.2, 0.02, push), "on its way it trusts the way"
    assert flee(FLAT, BODIES, state, near, fast, 3.0, 0.02, push)
    away, still = np.array((-10.0, 0.0, HEIGHT)), np.zeros(3)
    calm_steps = 0
    while flee(FLAT, BODIES, state, away, still, 3.0, 0.02, push):
        calm_steps += 1
    assert calm_steps == pytest.approx(0.5 / 0.02, abs=1)
    assert state[ACTIVE] == 0.0
    assert state[ENTRIES] == 1.0
    assert flee(FLAT, BODIES, state, near, fast, 3.0, 0.02, push)
    for _ in range(20):
        flee(FLAT, BODIES, state, away, still, 3.0, 0.02, push)
    flee(FLAT, BODIES, state, near, fast, 3.0, 0.02, push)
    for _ in range(20):
        assert flee(FLAT, BODIES, state, away, still, 3.0, 0.02, push), "an interruption starts the half second anew"

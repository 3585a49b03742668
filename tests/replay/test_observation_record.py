"""What is recorded of an observation is all of it, and comes back with the same bits."""

from __future__ import annotations

import dataclasses

import msgspec
import numpy as np
import orjson
from hypothesis import given, settings

from flightapp.core.types import Assignment, Observation, ObstacleSet, TargetTrack, TeamMember, VehicleState
from flightapp.recording.messages import ObservationRecord
from flightapp.recording.observation import Given, given_by, observation_record
from flightapp.recording.schema import encoder_of
from flightapp.safety.api import SafetyContext
from tests.replay.situations import Shape, shapes, situation
from tests.replay.test_fuzz import context

KNOWN = {
    Observation: {"t_s", "dt_s", "own", "team", "target", "obstacles", "boundary", "assignment"},
    VehicleState: {"t_s", "position_ned_m", "velocity_ned_m_s", "yaw_rad"},
    TeamMember: {"name", "state", "mode", "eta_s", "age_s"},
    TargetTrack: {"t_s", "position_ned_m", "velocity_ned_m_s", "covariance", "age_s"},
    ObstacleSet: {"t_s", "discs", "unseen"},
    Assignment: {"bearing_rad", "arrival_s", "rendezvous"},
    SafetyContext: {
        *("t_s", "dt_s", "name", "own", "own_age_s", "team", "target", "obstacles", "obstacles_age_s", "previous", "limits"),
        *("team_link_age_s", "battery_fraction", "heights_trusted"),
    },
}


def test_nothing_is_given_that_is_not_recorded() -> None:
    """A new field of an observation is recorded and read back (flightapp.recording.observation), then named here."""
    for kind, names in KNOWN.items():
        assert {field.name for field in dataclasses.fields(kind)} == names, kind


@settings(max_examples=40, deadline=None, database=None)
@given(shape=shapes)
def test_an_observation_comes_back_bit_for_bit(shape: Shape) -> None:
    for seen in situation(shape):
        told = dataclasses.replace(context(seen, None), heights_trusted=len(seen.team) % 2 == 0)
        again = through_the_file(seen, told)
        for name in ("t_s", "dt_s", "assignment", "obstacles", "boundary"):
            assert getattr(again.observation, name) == getattr(seen, name), name
        assert_same(again.observation.own, seen.own)
        assert (again.observation.target is None) == (seen.target is None)
        if again.observation.target is not None and seen.target is not None:
            assert_same(again.observation.target, seen.target)
        assert len(again.observation.team) == len(seen.team)
        for one, other in zip(again.observation.team, seen.team, strict=True):
            assert_same(one.state, other.state)
            assert (one.name, one.mode, one.eta_s, one.age_s) == (other.name, other.mode, other.eta_s, other.age_s)
        assert again.own_age_s == told.own_age_s
        assert again.team_link_age_s == told.team_link_age_s
        assert again.battery_fraction == told.battery_fraction
        assert again.heights_trusted == told.heights_trusted


def test_who_does_not_take_part_is_told_to_the_supervisor_only() -> None:
    shape = Shape(1, 0.0, 5.0, 0, False, "nothing", 0.0, 3, False, 0.1, "fresh", "line", False, 0.05, 1, 2.0)
    [seen] = situation(shape)
    told = context(seen, None)
    again = through_the_file(dataclasses.replace(seen, team=seen.team[:1]), told)
    assert [member.name for member in again.observation.team] == ["p2"]
    assert [member.name for member in again.team] == ["p2", "p3", "p4"]


def test_a_covariance_that_is_not_symmetric_comes_back_as_it_was() -> None:
    shape = Shape(1, 0.0, 5.0, 0, False, "nothing", 0.0, 0, False, 0.1, "fresh", "line", False, 0.05, 1, 2.0)
    [seen] = situation(shape)
    assert seen.target is not None
    track = dataclasses.replace(seen.target, covariance=np.arange(36.0).reshape(6, 6))
    again = through_the_file(dataclasses.replace(seen, target=track), context(seen, None))
    assert again.observation.target is not None
    assert np.array_equal(again.observation.target.covariance, track.covariance)


def through_the_file(seen: Observation, told: SafetyContext) -> Given:
    record = observation_record(seen, told, 1, planned=True, held=False)
    written = encoder_of(ObservationRecord)(record)
    return given_by(msgspec.convert(orjson.loads(written), ObservationRecord), seen.obstacles, seen.boundary)


def assert_same(one: VehicleState | TargetTrack, other: VehicleState | TargetTrack) -> None:
    for field in dataclasses.fields(one):
        assert np.array_equal(getattr(one, field.name), getattr(other, field.name)), field.name

from __future__ import annotations

import math

import numpy as np
import pymap3d
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightapp.core.geodesy import (
    GeodeticPoint,
    geodetic_to_mission,
    geodetic_to_px4_local,
    mission_to_geodetic,
    px4_local_to_geodetic,
)

DATUM = GeodeticPoint(47.3977, 8.5456, 488.0)

points = st.builds(GeodeticPoint, st.floats(-80, 80), st.floats(-180, 180), st.floats(-100, 3000))
metres = st.floats(-5000, 5000)
offsets = st.tuples(metres, metres, st.floats(-200, 200)).map(np.array)


@settings(max_examples=200, deadline=None)
@given(points, offsets)
def test_px4_local_there_and_back(origin: GeodeticPoint, local: np.ndarray) -> None:
    assert geodetic_to_px4_local(origin, px4_local_to_geodetic(origin, local)) == pytest.approx(local, abs=1e-3)


@settings(max_examples=200, deadline=None)
@given(points, offsets)
def test_mission_frame_there_and_back(datum: GeodeticPoint, position: np.ndarray) -> None:
    assert geodetic_to_mission(datum, mission_to_geodetic(datum, position)) == pytest.approx(position, abs=1e-2)


@given(points)
def test_an_origin_is_its_own_zero(origin: GeodeticPoint) -> None:
    assert np.abs(geodetic_to_px4_local(origin, origin)).max() < 0.2
    assert px4_local_to_geodetic(origin, np.zeros(3)) == origin


def test_north_east_and_down_point_where_they_should() -> None:
    north = geodetic_to_mission(DATUM, GeodeticPoint(DATUM.latitude_deg + 1e-3, DATUM.longitude_deg, DATUM.altitude_m))
    east = geodetic_to_mission(DATUM, GeodeticPoint(DATUM.latitude_deg, DATUM.longitude_deg + 1e-3, DATUM.altitude_m))
    assert north == pytest.approx([111.2, 0.0, 0.0], abs=0.1)
    assert east == pytest.approx([0.0, 75.5, 0.0], abs=0.1)
    assert geodetic_to_mission(DATUM, GeodeticPoint(DATUM.latitude_deg, DATUM.longitude_deg, 500.0))[2] == -12.0


def _two_reports(bearing_rad: float) -> tuple[np.ndarray, list[tuple[GeodeticPoint, np.ndarray]]]:
    """A place, and what two PX4s report that stand there with origins 1 km apart and 100 m different in height."""
    away = np.array([1000.0 * math.cos(bearing_rad), 1000.0 * math.sin(bearing_rad), -100.0])
    origins = [DATUM, mission_to_geodetic(DATUM, away)]
    place = 0.5 * away + np.array([30.0, -20.0, -5.0])
    there = mission_to_geodetic(DATUM, place)
    return place, [(origin, geodetic_to_px4_local(origin, there)) for origin in origins]


@pytest.mark.parametrize("bearing_deg", [0, 45, 90, 200, 270])
def test_vehicles_with_different_origins_agree_within_a_centimetre(bearing_deg: float) -> None:
    place, reports = _two_reports(math.radians(bearing_deg))
    for origin, local in reports:
        assert geodetic_to_mission(DATUM, px4_local_to_geodetic(origin, local)) == pytest.approx(place, abs=0.01)


def test_one_earth_model_for_both_would_shift_them_by_metres() -> None:
    """The unsafe twin: PX4's spherical metres undone with the ellipsoid."""
    _, reports = _two_reports(math.radians(90))
    places = []
    for origin, local in reports:
        latitude, longitude, _ = pymap3d.ned2geodetic(
            local[0], local[1], 0.0, origin.latitude_deg, origin.longitude_deg, origin.altitude_m
        )
        point = GeodeticPoint(float(latitude), float(longitude), origin.altitude_m - local[2])
        places.append(geodetic_to_mission(DATUM, point))
    assert np.linalg.norm(places[0] - places[1]) == pytest.approx(3.0, abs=0.1)


def test_one_sphere_for_both_would_misplace_what_was_surveyed() -> None:
    place, reports = _two_reports(math.radians(90))
    on_the_sphere = [geodetic_to_px4_local(DATUM, px4_local_to_geodetic(origin, local)) for origin, local in reports]
    assert on_the_sphere[0] == pytest.approx(on_the_sphere[1], abs=0.01)
    assert np.linalg.norm(on_the_sphere[0] - place) > 0.5

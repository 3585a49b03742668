from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from flightapp.cli import app
from flightapp.config.fence_text import flight_volume_toml, replace_flight_volume
from flightapp.config.kml import read_kml, write_kml
from flightapp.config.mission import FlightVolume, load_mission
from flightapp.core.errors import InputError
from flightapp.core.geodesy import GeodeticPoint

DEMO = Path(__file__).parents[2] / "missions" / "demo_two_pursuers.toml"
MISSION = load_mission(DEMO)
DATUM = MISSION.datum.as_point()
RING = "8.5450,47.3970,{0} 8.5460,47.3970,{0} 8.5460,47.3980,{0} 8.5450,47.3970,{0}"


def _kml(tmp_path: Path, body: str, head: str = "", namespace: str = ' xmlns="http://www.opengis.net/kml/2.2"') -> Path:
    path = tmp_path / "fence.kml"
    path.write_text(f'<?xml version="1.0"?>{head}<kml{namespace}><Document>{body}</Document></kml>')
    return path


def _polygon(name: str = "field", coordinates: str = RING.format(520), mode: str = "absolute") -> str:
    ring = f"<outerBoundaryIs><LinearRing><coordinates>{coordinates}</coordinates></LinearRing></outerBoundaryIs>"
    return f"<Placemark><name>{name}</name><Polygon><altitudeMode>{mode}</altitudeMode>{ring}</Polygon></Placemark>"


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.floats(0.3, 1.0), min_size=3, max_size=12),
    st.floats(5, 3000),
    st.floats(0, 50),
    st.floats(1, 200),
    st.booleans(),
    st.sampled_from(["land", "terminate"]),
    st.tuples(st.floats(-80, 80), st.floats(-179, 179), st.floats(-400, 4000)),
)
def test_a_round_trip_keeps_everything_within_a_centimetre(
    tmp_path_factory: pytest.TempPathFactory,
    radii: list[float],
    size_m: float,
    bottom_m: float,
    band_m: float,
    own_polygon: bool,
    action: str,
    datum: tuple[float, float, float],
) -> None:
    angles = [2 * math.pi * index / len(radii) for index in range(len(radii))]
    star = tuple((size_m * r * math.cos(a), size_m * r * math.sin(a)) for a, r in zip(angles, radii, strict=True))
    around = ((-2 * size_m, -2 * size_m), (2 * size_m, -2 * size_m), (2 * size_m, 2 * size_m), (-2 * size_m, 2 * size_m))
    volume = FlightVolume(
        vertices_m=star,
        height_min_m=bottom_m,
        height_max_m=bottom_m + band_m,
        contingency_m=7.0,
        contingency_height_m=3.0,
        contingency_vertices_m=around if own_polygon else None,
        outside_action=action,
    )
    place = MISSION.datum.model_copy(update=dict(zip(("latitude_deg", "longitude_deg", "altitude_m"), datum, strict=True)))
    path = tmp_path_factory.mktemp("kml") / "fence.kml"
    write_kml(MISSION.model_copy(update={"flight_volume": volume, "datum": place}), path)
    back = read_kml(path, place.as_point())
    assert [math.dist(*pair) < 0.01 for pair in zip(back.vertices_m, star, strict=True)] == [True] * len(star)
    if own_polygon:
        assert all(math.dist(*pair) < 0.01 for pair in zip(back.contingency_vertices_m, around, strict=True))
    else:
        assert back.contingency_vertices_m is None
        assert back.contingency_m == 7.0
    for name in ("height_min_m", "height_max_m", "contingency_height_m", "outside_action"):
        assert getattr(back, name) == getattr(volume, name)


def test_everything_that_a_person_wants_to_see_is_a_placemark(tmp_path: Path) -> None:
    path = tmp_path / "demo.kml"
    write_kml(MISSION, path)
    text = path.read_text()
    names = ("flight volume", "contingency volume", "protected boundary", "start of p1 (pursuer)", "start of e1 (evader)")
    assert all(f"<name>{name}</name>" in text for name in names)


@pytest.mark.parametrize("namespace", ["", ' xmlns="http://earth.google.com/kml/2.1"'])
def test_a_foreign_file_needs_a_polygon_only(tmp_path: Path, namespace: str) -> None:
    volume = read_kml(_kml(tmp_path, _polygon(), namespace=namespace), DATUM)
    assert len(volume.vertices_m) == 3
    assert volume.height_max_m == pytest.approx(520 - 488)
    relative = read_kml(_kml(tmp_path, _polygon(coordinates=RING.format(25), mode="relativeToGround")), DATUM)
    assert relative.height_max_m == 25
    flat = read_kml(_kml(tmp_path, _polygon(mode="clampToGround")), DATUM, MISSION.flight_volume)
    assert flat.height_max_m == MISSION.flight_volume.height_max_m


BOMB = '<!DOCTYPE kml [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;">]>'
BOWTIE = "8.5450,47.3970,520 8.5460,47.3980,520 8.5460,47.3970,520 8.5450,47.3980,520"


@pytest.mark.parametrize(
    ("body", "head", "sentence"),
    [
        ("", "", "no polygon; draw the flight volume as one and call it 'flight volume'"),
        ("<Placemark>", "", "not valid KML"),
        (_polygon("&b;"), BOMB, "has a document type declaration; KML has none"),
        (_polygon("a") + _polygon("b"), "", "2 polygons and none is called 'flight volume': a, b"),
        (_polygon("a") + _polygon("A"), "", "two polygons are called 'a'; their names must differ"),
        (_polygon(coordinates="8.5,47.3,5 8.6,north,5 8.5,47.4,5"), "", "corner '8.6,north,5': must read longitude,latitude"),
        (_polygon(coordinates="8.5,47.3,5 8.6,nan,5 8.5,47.4,5"), "", "corner '8.6,nan,5': must read longitude,latitude"),
        (_polygon(coordinates=BOWTIE), "", "vertices_m: the fence crosses itself"),
        (_polygon(coordinates=""), "", "must be one polygon with one outer ring of corners and no holes"),
        (_polygon(coordinates="9.5,47.3,520 9.6,47.3,520 9.5,47.4,520"), "", "vertices_m.0.1: "),
        (_polygon(mode="clampToGround"), "", "the polygon has no altitude; give its corners that of the flight volume's top"),
        (
            _polygon("flight volume") + _polygon("contingency volume", BOWTIE),
            "",
            "contingency_vertices_m: the fence crosses itself",
        ),
    ],
)
def test_a_broken_or_foreign_file_is_one_sentence(tmp_path: Path, body: str, head: str, sentence: str) -> None:
    path = _kml(tmp_path, body, head)
    with pytest.raises(InputError) as caught:
        read_kml(path, DATUM)
    assert str(caught.value).startswith(f"{path}: ")
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)


def test_no_file_an_archive_and_a_giant_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_kml(tmp_path / "none.kml", DATUM)
    path = tmp_path / "fence.kmz"
    path.write_bytes(b"PK\x03\x04")
    with pytest.raises(InputError, match="is a KMZ archive; save it as KML"):
        read_kml(path, DATUM)
    with path.open("wb") as file:
        file.truncate(10_000_001)
    with pytest.raises(InputError, match="larger than 10 MB"):
        read_kml(path, DATUM)


def test_the_commands_export_print_and_replace(tmp_path: Path) -> None:
    mission, kml = tmp_path / "mission.toml", tmp_path / "fence.kml"
    mission.write_text(DEMO.read_text())
    runner = CliRunner()
    assert runner.invoke(app, ["fence", "export", str(mission), str(kml)]).exit_code == 0
    printed = runner.invoke(app, ["fence", "import", str(mission), str(kml)])
    assert printed.output == flight_volume_toml(MISSION.flight_volume)
    kml.write_text(kml.read_text().replace("<value>5.0</value>", "<value>6.5</value>"))
    assert runner.invoke(app, ["fence", "import", str(mission), str(kml), "--write"]).exit_code == 0
    assert load_mission(mission).flight_volume.contingency_m == 6.5
    kept = [line for line in DEMO.read_text().splitlines() if line.startswith("#") or "#" in line]
    assert all(line in mission.read_text() for line in kept)
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["fence.kml", "mission.toml"]


def test_a_fence_that_the_mission_cannot_fly_in_changes_nothing(tmp_path: Path) -> None:
    mission = tmp_path / "mission.toml"
    mission.write_text(DEMO.read_text())
    small = MISSION.flight_volume.model_copy(update={"vertices_m": ((0.0, 0.0), (5.0, 0.0), (0.0, 5.0))})
    with pytest.raises(InputError, match="with the new fence: vehicles"):
        replace_flight_volume(mission, small)
    assert mission.read_text() == DEMO.read_text()
    assert [entry.name for entry in tmp_path.iterdir()] == ["mission.toml"]


@pytest.mark.parametrize(
    ("contingency", "sentence"),
    [
        (((-20.0, -40.0), (70.0, -40.0), (70.0, 20.0), (-20.0, 20.0)), "the corner (65.0, 30.0) of vertices_m lies outside"),
        (
            ((-20.0, -40.0), (70.0, -40.0), (70.0, 40.0), (20.0, 40.0), (20.0, 10.0), (10.0, 10.0), (10.0, 40.0), (-20.0, 40.0)),
            "an edge of the flight volume leads out of it",
        ),
        (((0.0, 0.0), (9.0, 9.0), (9.0, 0.0), (0.0, 9.0)), "the fence crosses itself"),
    ],
)
def test_the_contingency_volume_must_contain_the_flight_volume(
    contingency: tuple[tuple[float, float], ...], sentence: str
) -> None:
    fields = MISSION.flight_volume.model_dump() | {"contingency_vertices_m": contingency}
    with pytest.raises(ValueError, match=sentence.replace("(", r"\(").replace(")", r"\)")):
        FlightVolume.model_validate(fields)


def test_a_datum_elsewhere_moves_the_volume(tmp_path: Path) -> None:
    path = tmp_path / "demo.kml"
    write_kml(MISSION, path)
    moved = read_kml(path, GeodeticPoint(DATUM.latitude_deg + 0.0001, DATUM.longitude_deg, DATUM.altitude_m))
    assert moved.vertices_m[0][0] == pytest.approx(-15.0 - 11.12, abs=0.05)

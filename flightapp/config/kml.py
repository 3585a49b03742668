"""The fence as KML: drawn in a map program, or shown in one.

A file written here holds placemarks named as below, and what KML has no place for as extended data of the flight volume: a
round trip gives the same volume within a centimetre. A foreign file needs a polygon; names tell two apart. Coordinates are WGS84
longitude and latitude; altitudes are read as absolute (above the datum's altitude) or relative to the ground at the datum.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.parsers import expat

import numpy as np
from pydantic import ValidationError
from shapely.geometry import Polygon

from flightapp.config.mission import FlightVolume, Mission, Vertex
from flightapp.core.errors import InputError
from flightapp.core.geodesy import GeodeticPoint, geodetic_to_mission, mission_to_geodetic

BYTES_MAX = 10_000_000
NAMESPACE = "http://www.opengis.net/kml/2.2"
FLIGHT, CONTINGENCY, BOUNDARY = "flight volume", "contingency volume", "protected boundary"
NUMBERS = ("height_min_m", "height_max_m", "contingency_m", "contingency_height_m")
DATA = (*NUMBERS, "outside_action")
CLOSED_M = 0.01
BUFFER_SEGMENTS = 4


def read_kml(path: Path, datum: GeodeticPoint, drawn_over: FlightVolume | None = None) -> FlightVolume:
    """The flight volume drawn in `path`; what the file does not say (heights first) is taken from `drawn_over`.

    InputError names the file and what is wrong with it.
    """
    polygons = _polygons(path)
    flight = _chosen(path, polygons)
    fields: dict[str, Any] = {} if drawn_over is None else drawn_over.model_dump(exclude={"contingency_vertices_m"})
    fields["vertices_m"] = _in_mission_frame(path, flight, datum)
    _take_height(path, flight, fields, datum)
    fields |= _data(path, flight)
    contingency = polygons.get(CONTINGENCY)
    if contingency is not None and "contingency_m" not in _data(path, flight):
        fields["contingency_vertices_m"] = _in_mission_frame(path, contingency, datum)
    if "height_max_m" not in fields:
        raise InputError(f"{path}: the polygon has no altitude; give its corners that of the flight volume's top, as absolute")
    try:
        return FlightVolume.model_validate(fields)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        raise InputError(f"{path}: {f'{where}: ' if where else ''}{first['msg'].removeprefix('Value error, ')}") from None


def write_kml(mission: Mission, path: Path) -> None:
    """Flight volume, contingency volume, protected boundary and starts of `mission` as placemarks."""
    ET.register_namespace("", NAMESPACE)
    root = ET.Element(_tag("kml"))
    document = ET.SubElement(root, _tag("Document"))
    _text(document, "name", mission.name)
    volume, datum = mission.flight_volume, mission.datum.as_point()
    values = {name: getattr(volume, name) for name in DATA}
    if volume.contingency_vertices_m is not None:
        del values["contingency_m"]
    top_m = volume.height_max_m
    _polygon(_placemark(document, FLIGHT, values), volume.vertices_m, top_m, datum)
    outer = volume.contingency_vertices_m or _around(volume)
    _polygon(_placemark(document, CONTINGENCY), outer, top_m + volume.contingency_height_m, datum)
    line = mission.boundary.vertices_m + (mission.boundary.vertices_m[:1] if mission.boundary.closed else ())
    drawn = ET.SubElement(_placemark(document, BOUNDARY), _tag("LineString"))
    _text(drawn, "altitudeMode", "clampToGround")
    _text(drawn, "coordinates", _coordinates(line, 0.0, datum))
    for vehicle in mission.vehicles:
        point = ET.SubElement(_placemark(document, f"start of {vehicle.name} ({vehicle.role})"), _tag("Point"))
        place = ((vehicle.start.north_m, vehicle.start.east_m),)
        _text(point, "coordinates", _coordinates(place, vehicle.start.ground_height_m, datum))
    ET.indent(root)
    try:
        path.write_bytes(ET.tostring(root, encoding="utf-8", xml_declaration=True))
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from None


def _polygons(path: Path) -> dict[str, ET.Element]:
    """Polygon elements by the lower-case name of their placemark."""
    root = ET.fromstring(_checked_bytes(path))
    for element in root.iter():  # Older files name another namespace, or none.
        element.tag = _tag(element.tag.rpartition("}")[2])
    found: dict[str, ET.Element] = {}
    for index, placemark in enumerate(root.iter(_tag("Placemark"))):
        if placemark.find(f".//{_tag('Polygon')}") is not None:
            name = (placemark.findtext(_tag("name")) or f"polygon {index + 1}").strip().lower()
            if name in found:
                raise InputError(f"{path}: two polygons are called '{name}'; their names must differ")
            found[name] = placemark
    return found


def _checked_bytes(path: Path) -> bytes:
    """The file's bytes, of a size and kind that may be parsed: no document type, so no entities that grow or read files."""
    try:
        if path.stat().st_size > BYTES_MAX:
            raise InputError(f"{path}: larger than {BYTES_MAX / 1e6:g} MB; a fence is a few kilobytes")
        content = path.read_bytes()
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    if content.startswith(b"PK"):
        raise InputError(f"{path}: is a KMZ archive; save it as KML, or unpack its doc.kml")

    def refuse(*_: object) -> None:
        raise InputError(f"{path}: has a document type declaration; KML has none")

    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = refuse
    try:
        parser.Parse(content, True)
    except expat.ExpatError as error:
        raise InputError(f"{path}: not valid KML: {error}") from None
    return content


def _chosen(path: Path, polygons: dict[str, ET.Element]) -> ET.Element:
    others = [name for name in polygons if name != CONTINGENCY]
    if FLIGHT in polygons:
        return polygons[FLIGHT]
    if len(others) == 1:
        return polygons[others[0]]
    if not others:
        raise InputError(f"{path}: no polygon; draw the flight volume as one and call it '{FLIGHT}'")
    raise InputError(f"{path}: {len(others)} polygons and none is called '{FLIGHT}': {', '.join(others)}")


def _corners(path: Path, placemark: ET.Element) -> list[tuple[float, float, float | None]]:
    """Longitude, latitude, altitude of the corners of the outer ring, the repeated last one left out."""
    rings = placemark.findall(f".//{_tag('outerBoundaryIs')}//{_tag('coordinates')}")
    name = placemark.findtext(_tag("name")) or "polygon"
    if len(rings) != 1 or not (rings[0].text or "").strip() or placemark.find(f".//{_tag('innerBoundaryIs')}") is not None:
        raise InputError(f"{path}: '{name}' must be one polygon with one outer ring of corners and no holes")
    corners: list[tuple[float, float, float | None]] = []
    for entry in (rings[0].text or "").split():
        try:
            numbers = [float(number) for number in entry.split(",")]
        except ValueError:
            numbers = []
        if len(numbers) not in (2, 3) or not np.isfinite(numbers).all() or abs(numbers[0]) > 180 or abs(numbers[1]) > 90:
            raise InputError(f"{path}: '{name}': corner '{entry[:40]}': must read longitude,latitude,altitude")
        corners.append((numbers[0], numbers[1], numbers[2] if len(numbers) == 3 else None))
    return corners


def _in_mission_frame(path: Path, placemark: ET.Element, datum: GeodeticPoint) -> tuple[Vertex, ...]:
    vertices = []
    for longitude, latitude, _ in _corners(path, placemark):
        north, east, _ = geodetic_to_mission(datum, GeodeticPoint(latitude, longitude, datum.altitude_m)).tolist()
        vertices.append((north, east))
    if len(vertices) > 1 and np.hypot(*np.subtract(vertices[0], vertices[-1])) < CLOSED_M:
        vertices.pop()
    return tuple(vertices)


def _take_height(path: Path, placemark: ET.Element, fields: dict[str, Any], datum: GeodeticPoint) -> None:
    """The top from the corners' altitudes, where their mode says what they count from."""
    mode = placemark.findtext(f".//{_tag('altitudeMode')}")
    altitudes = [altitude for _, _, altitude in _corners(path, placemark) if altitude is not None]
    if altitudes and mode in ("absolute", "relativeToGround"):
        fields["height_max_m"] = round(min(altitudes) - (datum.altitude_m if mode == "absolute" else 0.0), 3)


def _data(path: Path, placemark: ET.Element) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for data in placemark.iter(_tag("Data")):
        name, value = data.get("name", ""), (data.findtext(_tag("value")) or "").strip()
        if name in NUMBERS:
            try:
                values[name] = float(value)
            except ValueError:
                raise InputError(f"{path}: {name} = '{value[:40]}': must be a number") from None
        elif name in DATA:
            values[name] = value
    return values


def _around(volume: FlightVolume) -> Sequence[Vertex]:
    """What `contingency_m` around the flight volume looks like, its round corners as short edges."""
    ring = Polygon(volume.vertices_m).buffer(volume.contingency_m, quad_segs=BUFFER_SEGMENTS).exterior
    return [(north, east) for north, east in ring.coords[:-1]]


def _polygon(placemark: ET.Element, vertices: Sequence[Vertex], height_m: float, datum: GeodeticPoint) -> None:
    polygon = ET.SubElement(placemark, _tag("Polygon"))
    _text(polygon, "altitudeMode", "absolute")
    ring = ET.SubElement(ET.SubElement(polygon, _tag("outerBoundaryIs")), _tag("LinearRing"))
    _text(ring, "coordinates", _coordinates([*vertices, vertices[0]], height_m, datum))


def _coordinates(vertices: Sequence[Vertex], height_m: float, datum: GeodeticPoint) -> str:
    points = [mission_to_geodetic(datum, np.array([north, east, -height_m])) for north, east in vertices]
    return " ".join(f"{point.longitude_deg:.9f},{point.latitude_deg:.9f},{point.altitude_m:.3f}" for point in points)


def _placemark(document: ET.Element, name: str, data: dict[str, object] | None = None) -> ET.Element:
    placemark = ET.SubElement(document, _tag("Placemark"))
    _text(placemark, "name", name)
    if data:
        extended = ET.SubElement(placemark, _tag("ExtendedData"))
        for key, value in data.items():
            _text(ET.SubElement(extended, _tag("Data"), name=key), "value", str(value))
    return placemark


def _text(parent: ET.Element, name: str, text: str) -> None:
    ET.SubElement(parent, _tag(name)).text = text


def _tag(name: str) -> str:
    return f"{{{NAMESPACE}}}{name}"

"""The mission: who flies where, what is protected, when the evader counts as captured."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, field_validator, model_validator
from shapely.geometry import LineString, Point, Polygon

from flightapp.config.known_obstacles import KnownObstacle, KnownSphere, distance_to_column_m
from flightapp.config.loading import Strict, load
from flightapp.config.tracking import Controller
from flightapp.config.wind import HarmonicWind
from flightapp.core.geodesy import GeodeticPoint
from flightapp.core.types import Boundary

Coordinate = Annotated[float, Field(ge=-20_000, le=20_000)]
"""A place in the mission frame, m: the frame is flat, so it ends 20 km from the datum."""
HEIGHT_ABOVE_GROUND_MIN_M = 1.0
COLUMN_GAP_M = 0.5
"""From where a vehicle climbs or waits to what is known, at least."""

Vertex = tuple[Coordinate, Coordinate]
Scalar = float | int | bool | str


class Datum(Strict):
    """Origin of the mission frame."""

    latitude_deg: float = Field(ge=-85, le=85)
    longitude_deg: float = Field(ge=-180, le=180)
    altitude_m: float = Field(ge=-500, le=9000)

    def as_point(self) -> GeodeticPoint:
        return GeodeticPoint(self.latitude_deg, self.longitude_deg, self.altitude_m)


class FlightVolume(Strict):
    """The fence: a polygon (north, east) and a band of heights above the datum, and the contingency volume around it.

    In the contingency volume a vehicle holds and is pushed back. Outside it `outside_action` ends its flight.
    """

    vertices_m: tuple[Vertex, ...] = Field(min_length=3)
    height_min_m: float = Field(default=1.0, ge=0)
    height_max_m: float = Field(gt=0, le=500)
    contingency_m: float = Field(default=5.0, gt=0, le=1000)
    """The contingency volume reaches this far around the polygon, where it has no polygon of its own."""
    contingency_vertices_m: Annotated[tuple[Vertex, ...], Field(min_length=3)] | None = None
    """A polygon of its own, which must contain the flight volume."""
    contingency_height_m: float = Field(default=5.0, gt=0, le=500)
    """How far above the band the contingency volume reaches; below the band there is none."""
    outside_action: Literal["land", "terminate"] = "land"
    """What ends the flight of a vehicle outside the contingency volume."""

    @field_validator("vertices_m", "contingency_vertices_m")
    @classmethod
    def _does_not_cross_itself(cls, vertices: tuple[Vertex, ...] | None) -> tuple[Vertex, ...] | None:
        if vertices is None:
            return None
        _refuse_repeated(vertices, closed=True)
        polygon = Polygon(vertices)
        if not polygon.is_valid or polygon.area <= 0.0:
            raise ValueError("the fence crosses itself or has no area; list its corners once, in order around the volume")
        return vertices

    @model_validator(mode="after")
    def _is_nested(self) -> FlightVolume:
        if self.contingency_vertices_m is None:
            return self
        contingency = Polygon(self.contingency_vertices_m)
        for vertex in self.vertices_m:
            if not contingency.covers(Point(vertex)):
                raise ValueError(
                    f"contingency_vertices_m: the corner {vertex} of vertices_m lies outside; "
                    "the contingency volume must contain the whole flight volume"
                )
        if not contingency.covers(Polygon(self.vertices_m)):
            raise ValueError(
                "contingency_vertices_m: an edge of the flight volume leads out of it; "
                "the contingency volume must contain the whole flight volume"
            )
        return self

    @model_validator(mode="after")
    def _band_is_open(self) -> FlightVolume:
        if self.height_max_m <= self.height_min_m:
            raise ValueError(f"height_max_m = {self.height_max_m}: must be greater than height_min_m = {self.height_min_m}")
        return self


class ProtectedBoundary(Strict):
    """The edge of the protected area, which the evader must not cross."""

    vertices_m: tuple[Vertex, ...] = Field(min_length=2)
    closed: bool = False

    @field_validator("vertices_m")
    @classmethod
    def _is_a_line(cls, vertices: tuple[Vertex, ...]) -> tuple[Vertex, ...]:
        _refuse_repeated(vertices, closed=False)
        if not LineString(vertices).is_simple:
            raise ValueError("the boundary crosses itself; list its vertices in order")
        return vertices

    @model_validator(mode="after")
    def _is_a_ring_when_closed(self) -> ProtectedBoundary:
        if self.closed:
            _refuse_repeated(self.vertices_m, closed=True, field="vertices_m")
            if len(self.vertices_m) < 3:
                raise ValueError(f"vertices_m = {self.vertices_m}: a closed boundary must have at least 3 vertices")
            if not Polygon(self.vertices_m).is_valid:
                raise ValueError("vertices_m: the closed boundary crosses itself; list its vertices once, in order around it")
        return self

    def as_boundary(self) -> Boundary:
        return Boundary(np.array(self.vertices_m, dtype=np.float64), self.closed)


class Capture(Strict):
    """When the evader counts as captured."""

    radius_m: float = Field(default=0.4, gt=0, le=20)
    """A pursuer within this distance satisfies the capture condition."""
    hold_radius_m: float = Field(default=0.4, gt=0, le=20)
    """Radius of the encirclement at which the pursuers hold relative to the evader."""
    hold_tolerance_m: float = Field(default=1.0, gt=0, le=10)
    angular_gap_min_deg: float = Field(default=90.0, ge=0, le=180)
    """Two pursuers must be seen from the evader at least this far apart; three or more must enclose it."""
    dwell_s: float = Field(default=0.5, ge=0, le=60)
    mode: Literal["first", "all"] = "all"

    @model_validator(mode="after")
    def _hold_is_a_capture(self) -> Capture:
        if self.hold_radius_m > self.radius_m:
            raise ValueError(
                f"hold_radius_m = {self.hold_radius_m}: must not exceed radius_m = {self.radius_m}; holding must not undo capture"
            )
        return self


class Start(Strict):
    """Where a vehicle stands before take-off, in the mission frame; on the ground."""

    north_m: Coordinate
    east_m: Coordinate
    heading_deg: float = Field(default=0.0, ge=-180, le=360)
    ground_height_m: float = Field(default=0.0, ge=-100, le=500)
    """Height of the ground there above the datum."""


class Station(Strict):
    """Where a vehicle waits for the pursuit, in the mission frame, at its flight height."""

    north_m: Coordinate
    east_m: Coordinate


class Strategy(Strict):
    """A planner or an evader policy by its registered name, with parameters from a file, from here, or both (here wins).

    Paths are relative to the file that they stand in.
    """

    name: str = Field(min_length=1)
    parameters_file: Path | None = None
    parameters: dict[str, Scalar | list[float] | dict[str, Scalar]] = {}


class Vehicle(Strict):
    """One member of the fleet."""

    name: str = Field(pattern=r"^[a-z][a-z0-9_-]{0,31}$")
    role: Literal["pursuer", "evader"]
    system_id: int = Field(ge=1, le=250)
    start: Start
    station: Station | None = None
    """With `ingress = "planned"`: it flies there after take-off; without one it waits for the pursuit above its start."""
    strategy: Strategy
    height_m: float | None = Field(default=None, gt=0)
    """Own flight height above the datum where it differs from the mission's."""
    speed_max_m_s: float | None = Field(default=None, gt=0)
    """Own speed limit in this mission, never above the profile's."""
    camera: bool = True
    """False: flies on the mission's surveyed obstacles instead of a depth camera."""


class Cylinder(Strict):
    """A vertical cylinder standing on the ground."""

    north_m: Coordinate
    east_m: Coordinate
    radius_m: float = Field(gt=0)
    height_m: float = Field(gt=0)


class Box(Strict):
    """A box standing on the ground; `length_m` along `heading_deg`, `width_m` across."""

    north_m: Coordinate
    east_m: Coordinate
    length_m: float = Field(gt=0)
    width_m: float = Field(gt=0)
    height_m: float = Field(gt=0)
    heading_deg: float = 0.0


class Obstacles(Strict):
    """Surveyed obstacles. Simulation builds its world of them; vehicles with a camera are not told."""

    cylinders: tuple[Cylinder, ...] = ()
    boxes: tuple[Box, ...] = ()


class TargetKnowledge(Strict):
    """What pursuers know of the evader besides what their cameras see."""

    telemetry: Literal["always", "until-pursuit"] = "always"
    """How long the evader's own shared state counts: in the whole flight, or until the pursuit begins and cameras must do."""
    when_silent: Literal["sightings", "lost"] = "sightings"
    """When its telemetry has ended: go on with what cameras see of it, or hold it for lost."""


class Simulation(Strict):
    """What only `flightapp sim` reads."""

    wind_north_m_s: float = Field(default=0.0, ge=-20, le=20)
    wind_east_m_s: float = Field(default=0.0, ge=-20, le=20)
    gust_m_s: float = Field(default=0.0, ge=0, le=15)
    harmonic_wind: HarmonicWind | None = None
    """On top of these: harmonics with a gust step, stronger with height."""
    velocity_loop: Literal["reference", "px4"] = "reference"
    """Of the mock autopilots: the reference multirotor's, which takes a wind out within a second, or PX4's default gains."""
    origin_offset_m: float = Field(default=50.0, ge=0, le=5000)
    """How far the local origins of the mock autopilots lie apart."""
    faults: dict[str, Path] = {}
    """Fault script (TOML) of a vehicle's mock autopilot, by vehicle name."""


class Mission(Strict):
    """One mission of one fleet."""

    name: str = Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]{0,63}$")
    fleet: str = Field(default="fleet", pattern=r"^[a-z][a-z0-9_-]{0,31}$")
    description: str = ""
    height_m: float = Field(gt=0, le=500)
    """Flight height above the datum."""
    return_height_m: float = Field(gt=0, le=500)
    """Lowest height above the datum at which a vehicle returns: above every obstacle."""
    return_height_step_m: float = Field(default=2.0, ge=1.0, le=50)
    """Each further vehicle of the list returns this much higher: their ways home lie one above the other."""
    time_limit_s: float = Field(gt=0, le=3600)
    """Length of the pursuit; after it the mission ends with the outcome `timeout`."""
    start_timeout_s: float = Field(default=60.0, gt=0, le=600)
    """How long a vehicle in the air waits for the others to be ready."""
    evader_speed_assumed_m_s: float = Field(default=4.0, gt=0, le=50)
    """Top speed of the evader where no estimate of it exists."""
    target_contact_allowed: bool = False
    """False: no pursuer comes nearer to the evader than the profile's `safety.target_keep_out_m`."""
    datum: Datum
    flight_volume: FlightVolume
    boundary: ProtectedBoundary
    capture: Capture = Capture()
    target: TargetKnowledge = TargetKnowledge()
    controller: Controller | None = None
    """Who makes pursuers follow the decided velocity, where that is not as the profile says."""
    vehicles: tuple[Vehicle, ...] = Field(min_length=1)
    obstacles: Obstacles = Obstacles()
    known_obstacles: tuple[KnownObstacle, ...] = ()
    """What planned ways lead around: every vehicle is told, and simulation does not build it. Strategies are not told."""
    ingress: Literal["none", "planned"] = "none"
    """How vehicles with a station get there before the pursuit: along a way planned around the known obstacles."""
    ingress_handover_m: float = Field(default=15.0, ge=0, le=1000)
    """A pursuer on its ingress that comes this near to the evader begins the pursuit at once, and with it all; 0: never."""
    way_out: Literal["none", "planned"] = "none"
    """What a pursuer does whose strategy is trapped: fly a way out that is planned around the known obstacles."""
    way_home: Literal["autopilot", "planned"] = "autopilot"
    """How a vehicle returns: by the autopilot's own mode, or first along a way planned around the known obstacles."""
    simulation: Simulation = Simulation()

    @model_validator(mode="after")
    def _is_flyable(self) -> Mission:
        _check_unique(self)
        _check_boundary(self)
        _check_starts(self)
        _check_heights(self)
        _check_return_heights(self)
        _check_known_obstacles(self)
        _check_stations(self)
        _check_columns(self)
        _check_dwell(self)
        return self

    def vehicle(self, name: str) -> Vehicle:
        """The vehicle called `name`; KeyError otherwise."""
        for vehicle in self.vehicles:
            if vehicle.name == name:
                return vehicle
        raise KeyError(name)

    def return_height_of(self, vehicle: Vehicle) -> float:
        """Height above the datum at which `vehicle` returns, m."""
        return self.return_height_m + self.return_height_step_m * self.vehicles.index(vehicle)

    def height_of(self, vehicle: Vehicle) -> float:
        """Flight height of `vehicle` above the datum, m."""
        return self.height_m if vehicle.height_m is None else vehicle.height_m


def load_mission(path: Path) -> Mission:
    """The validated mission in `path`; InputError names file, field, value and what would be right."""
    return load(Mission, path)


def _check_unique(mission: Mission) -> None:
    names: dict[str, int] = {}
    ids: dict[int, int] = {}
    for index, vehicle in enumerate(mission.vehicles):
        if vehicle.name in names:
            raise ValueError(
                f"vehicles[{index}].name = '{vehicle.name}': vehicles[{names[vehicle.name]}] has it too; names must differ"
            )
        if vehicle.system_id in ids:
            raise ValueError(
                f"vehicles[{index}].system_id = {vehicle.system_id}: vehicles[{ids[vehicle.system_id]}] has it too; "
                "system ids must differ"
            )
        names[vehicle.name] = index
        ids[vehicle.system_id] = index
    evaders = [index for index, vehicle in enumerate(mission.vehicles) if vehicle.role == "evader"]
    if len(evaders) > 1:
        raise ValueError(
            f"vehicles[{evaders[1]}].role = 'evader': vehicles[{evaders[0]}] is the evader already; one is supported"
        )
    for name in mission.simulation.faults:
        if name not in names:
            raise ValueError(f"simulation.faults.{name}: no vehicle has this name; known: {', '.join(names)}")


def _check_boundary(mission: Mission) -> None:
    boundary = mission.boundary
    line = Polygon(boundary.vertices_m) if boundary.closed else LineString(boundary.vertices_m)
    if not line.intersects(Polygon(mission.flight_volume.vertices_m)):
        raise ValueError(
            f"boundary.vertices_m = {boundary.vertices_m}: lies wholly outside the flight volume, nobody could reach it; "
            "it must run through flight_volume.vertices_m"
        )


def _check_starts(mission: Mission) -> None:
    volume = Polygon(mission.flight_volume.vertices_m)
    protected = Polygon(mission.boundary.vertices_m) if mission.boundary.closed else None
    for index, vehicle in enumerate(mission.vehicles):
        where = (vehicle.start.north_m, vehicle.start.east_m)
        if not volume.contains(Point(where)):
            raise ValueError(
                f"vehicles[{index}].start = {where}: {vehicle.role} '{vehicle.name}' starts outside the flight volume; "
                "it must lie inside flight_volume.vertices_m"
            )
        if vehicle.role == "evader" and protected is not None and protected.contains(Point(where)):
            raise ValueError(
                f"vehicles[{index}].start = {where}: the evader starts inside the protected boundary; it must start outside"
            )
        for other_index in range(index):
            other = mission.vehicles[other_index].start
            if math.dist(where, (other.north_m, other.east_m)) < 1.0:
                raise ValueError(
                    f"vehicles[{index}].start = {where}: closer than 1 m to vehicles[{other_index}]; starts must be apart"
                )
        for cylinder_index, cylinder in enumerate(mission.obstacles.cylinders):
            if math.dist(where, (cylinder.north_m, cylinder.east_m)) < cylinder.radius_m + 0.5:
                raise ValueError(
                    f"vehicles[{index}].start = {where}: inside or closer than 0.5 m to obstacles.cylinders[{cylinder_index}]; "
                    "move the start or the obstacle"
                )
        for box_index, box in enumerate(mission.obstacles.boxes):
            if _distance_to_box_m(where, box) < 0.5:
                raise ValueError(
                    f"vehicles[{index}].start = {where}: inside or closer than 0.5 m to obstacles.boxes[{box_index}]; "
                    "move the start or the obstacle"
                )


def _check_heights(mission: Mission) -> None:
    volume = mission.flight_volume
    for index, vehicle in enumerate(mission.vehicles):
        height = mission.height_of(vehicle)
        if not volume.height_min_m < height < volume.height_max_m:
            field = "height_m" if vehicle.height_m is None else f"vehicles[{index}].height_m"
            raise ValueError(
                f"{field} = {height}: outside the flight volume's band; "
                f"it must lie between height_min_m = {volume.height_min_m} and height_max_m = {volume.height_max_m}"
            )
        above_ground = height - vehicle.start.ground_height_m
        if above_ground < HEIGHT_ABOVE_GROUND_MIN_M:
            raise ValueError(
                f"vehicles[{index}].start.ground_height_m = {vehicle.start.ground_height_m}: the flight height is "
                f"{above_ground:g} m above it; it must be at least {HEIGHT_ABOVE_GROUND_MIN_M:g} m"
            )


def _check_return_heights(mission: Mission) -> None:
    heights = [cylinder.height_m for cylinder in mission.obstacles.cylinders] + [box.height_m for box in mission.obstacles.boxes]
    tallest = max(heights, default=0.0)
    if mission.return_height_m <= tallest:
        raise ValueError(
            f"return_height_m = {mission.return_height_m}: the autopilot flies home at this height and sees no obstacle; "
            f"it must be greater than the tallest obstacle, {tallest:g} m"
        )
    for index, vehicle in enumerate(mission.vehicles):
        height, ceiling = mission.return_height_of(vehicle), mission.flight_volume.height_max_m
        if height < mission.height_of(vehicle):
            raise ValueError(
                f"return_height_m = {mission.return_height_m}: must not be lower than the flight height of vehicles[{index}], "
                f"{mission.height_of(vehicle):g} m"
            )
        if height >= ceiling:
            raise ValueError(
                f"return_height_m = {mission.return_height_m}: vehicles[{index}] returns at {height:g} m; "
                f"it must stay below flight_volume.height_max_m = {ceiling:g}"
            )


def _check_known_obstacles(mission: Mission) -> None:
    if mission.way_home == "planned":
        return
    for index, known in enumerate(mission.known_obstacles):
        top = known.height_m + known.radius_m if isinstance(known, KnownSphere) else known.top_m
        if top is None or top >= mission.return_height_m:
            reach = "without end" if top is None else f"to {top:g} m"
            raise ValueError(
                f"known_obstacles[{index}] reaches up {reach}, and the autopilot returns straight at return_height_m = "
                f'{mission.return_height_m:g}; set way_home = "planned", or return above it'
            )


def _check_stations(mission: Mission) -> None:
    stations = [(index, vehicle.station) for index, vehicle in enumerate(mission.vehicles) if vehicle.station is not None]
    if mission.ingress == "none" and stations:
        raise ValueError(
            f'vehicles[{stations[0][0]}].station: it is flown to only with ingress = "planned"; set that, or leave it'
        )
    if mission.ingress == "planned" and not stations:
        raise ValueError(
            'ingress = "planned": no vehicle has a station; it must have one: station = { north_m = 20.0, east_m = 5.0 }'
        )
    volume = Polygon(mission.flight_volume.vertices_m)
    for index, station in stations:
        where = (station.north_m, station.east_m)
        if not volume.contains(Point(where)):
            raise ValueError(
                f"vehicles[{index}].station = {where}: lies outside the flight volume; it must lie in flight_volume.vertices_m"
            )


def _check_columns(mission: Mission) -> None:
    """Vehicles climb above their starts, come down there, and wait at their stations: nothing that is known may be there."""
    for index, vehicle in enumerate(mission.vehicles):
        ground, height = vehicle.start.ground_height_m, mission.height_of(vehicle)
        highest = max(height, mission.return_height_of(vehicle))
        columns: list[tuple[str, Start | Station, float, float]] = [("start", vehicle.start, ground, highest)]
        if vehicle.station is not None:
            columns.append(("station", vehicle.station, height, height))
        for field, place, bottom, top in columns:
            for known_index, known in enumerate(mission.known_obstacles):
                distance = distance_to_column_m(known, place.north_m, place.east_m, bottom, top)
                if distance < COLUMN_GAP_M:
                    raise ValueError(
                        f"vehicles[{index}].{field} = {(place.north_m, place.east_m)}: '{vehicle.name}' would fly {bottom:g} to "
                        f"{top:g} m above it, inside or closer than {COLUMN_GAP_M:g} m to known_obstacles[{known_index}]; "
                        f"move the {field} or the obstacle"
                    )


def _check_dwell(mission: Mission) -> None:
    if mission.capture.dwell_s >= mission.time_limit_s:
        raise ValueError(
            f"capture.dwell_s = {mission.capture.dwell_s}: must be shorter than time_limit_s = {mission.time_limit_s:g}"
        )


def _refuse_repeated(vertices: tuple[Vertex, ...], *, closed: bool, field: str = "") -> None:
    """ValueError where two neighbouring vertices are the same point."""
    following = vertices[1:] + vertices[:1] if closed else vertices[1:]
    for index, (vertex, after) in enumerate(zip(vertices, following, strict=False)):
        if math.dist(vertex, after) == 0.0:
            where = f"vertices {index} and {(index + 1) % len(vertices)} are the same point {vertex}"
            ring = "; a closed line returns to its first vertex by itself" if closed and index + 1 == len(vertices) else ""
            raise ValueError(f"{f'{field}: ' if field else ''}{where}; list each once{ring}")


def _distance_to_box_m(point: Vertex, box: Box) -> float:
    heading = math.radians(box.heading_deg)
    north, east = point[0] - box.north_m, point[1] - box.east_m
    along = abs(north * math.cos(heading) + east * math.sin(heading)) - box.length_m / 2
    across = abs(-north * math.sin(heading) + east * math.cos(heading)) - box.width_m / 2
    return math.hypot(max(along, 0.0), max(across, 0.0))

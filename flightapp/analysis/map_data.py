"""What the map of a run shows, in metres north and east, before anyone draws it."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from flightapp.analysis.outcome import captured_s, pursuers_of, pursuit_start_s
from flightapp.analysis.run import Run, VehicleRun
from flightapp.config.known_obstacles import KnownBox, KnownObstacle
from flightapp.config.mission import Box
from flightapp.core.types import Array
from flightapp.recording.phases import Window
from flightapp.recording.reader import discs_of

VEHICLE_COLOURS = ("#1b7fc4", "#0f9d76", "#a85cb8", "#56b4e9", "#b58900", "#7b8794")
EVADER_COLOUR = "#d1495b"
MODE_COLOURS = ("#7b61d1", "#00a0c6", "#c2589a", "#7f9a1b", "#946c00", "#4a5568")
INK = "#1f2933"
OTHER_COLOUR = "#b8bfc8"
OTHER_LABEL = "before and after the pursuit"
EVADER_LABEL = "evader"


@dataclass(frozen=True, slots=True)
class Stretch:
    """Part of one vehicle's track flown in one mode, points (n, 2) north, east at times (n,) since the pursuit began, s."""

    vehicle: str
    label: str
    colour: str
    t_s: Array
    points_m: Array


@dataclass(frozen=True, slots=True)
class Marker:
    """A named point."""

    kind: str
    """start or capture."""
    text: str
    colour: str
    point_m: tuple[float, float]
    label_above: bool
    """The side of the point on which the track leaves room for the text."""


@dataclass(frozen=True, slots=True)
class MapData:
    """Everything on the map; outlines are (n, 2) north, east."""

    stretches: tuple[Stretch, ...]
    markers: tuple[Marker, ...]
    perceived: tuple[Array, ...]
    obstacles: tuple[Array, ...]
    known: tuple[Array, ...]
    """What planned ways lead around."""
    ways: tuple[Array, ...]
    """As they were planned: ingress, out of traps, home."""
    boundary: Array | None
    fence: Array | None
    low_m: tuple[float, float]
    high_m: tuple[float, float]


def map_data(run: Run) -> MapData:
    """The map of `run`: true tracks where known, discs as the pursuers finally perceived them."""
    stretches, markers = _tracks(run)
    mission = run.mission
    boundary = None if mission is None else _line(mission.boundary.vertices_m, mission.boundary.closed)
    fence = None if mission is None else _line(mission.flight_volume.vertices_m, True)
    obstacles: list[Array] = []
    if mission is not None:
        obstacles += [_circle(c.north_m, c.east_m, c.radius_m) for c in mission.obstacles.cylinders]
        obstacles += [_rectangle(box) for box in mission.obstacles.boxes]
    known = [] if mission is None else [_known(one) for one in mission.known_obstacles]
    ways = [way for vehicle in run.vehicles for way in _ways(vehicle)]
    drawn = [stretch.points_m for stretch in stretches] + [line for line in (boundary, fence) if line is not None]
    drawn += [*obstacles, *known, *ways]
    everything = np.concatenate(drawn) if drawn else np.zeros((1, 2))
    low, high = everything.min(axis=0) - 2.0, everything.max(axis=0) + 2.0
    perceived = tuple(outline for vehicle in pursuers_of(run) for outline in _perceived(vehicle))
    return MapData(
        tuple(stretches),
        tuple(markers),
        perceived,
        tuple(obstacles),
        tuple(known),
        tuple(ways),
        boundary,
        fence,
        (float(low[0]), float(low[1])),
        (float(high[0]), float(high[1])),
    )


def origin_s(run: Run) -> float:
    """Time zero of every picture: the start of the pursuit, else the first sample."""
    start_s = pursuit_start_s(run)
    if start_s is not None:
        return start_s
    return min((float(series.t_s[0]) for one in run.recordings for series in one.series.values()), default=0.0)


def origin_name(run: Run) -> str:
    """What began at time zero."""
    return "recording" if pursuit_start_s(run) is None else "pursuit"


def vehicle_colours(run: Run) -> dict[str, str]:
    """One colour for each vehicle; the evader always has the same."""
    colours: dict[str, str] = {}
    others = 0
    for vehicle in run.vehicles:
        if vehicle.role == "evader":
            colours[vehicle.name] = EVADER_COLOUR
        else:
            colours[vehicle.name] = VEHICLE_COLOURS[others % len(VEHICLE_COLOURS)]
            others += 1
    return colours


def _tracks(run: Run) -> tuple[list[Stretch], list[Marker]]:
    zero_s = origin_s(run)
    modes: dict[str, str] = {}
    stretches: list[Stretch] = []
    markers: list[Marker] = []
    for vehicle in run.vehicles:
        track = vehicle.track
        if track is None:
            continue
        labels = _labels(vehicle, track.t_s)
        for label in dict.fromkeys(labels):
            if label not in (OTHER_LABEL, EVADER_LABEL):
                modes.setdefault(label, MODE_COLOURS[len(modes) % len(MODE_COLOURS)])
        known = {**modes, OTHER_LABEL: OTHER_COLOUR, EVADER_LABEL: EVADER_COLOUR}
        changes = [0, *(i for i in range(1, len(labels)) if labels[i] != labels[i - 1]), len(labels)]
        for first, last in itertools.pairwise(changes):
            part = slice(first, min(last + 1, len(labels)))
            label = labels[first]
            stretches.append(Stretch(vehicle.name, label, known[label], track.t_s[part] - zero_s, track.position_ned_m[part, :2]))
        start, middle = track.position_ned_m[0], track.position_ned_m[len(track) // 2]
        colour = EVADER_COLOUR if vehicle.role == "evader" else INK
        above = bool(middle[0] < start[0] - 1.0)
        markers.append(Marker("start", vehicle.name, colour, (float(start[0]), float(start[1])), above))
    when_s, evader = captured_s(run), run.evader_track()
    if when_s is not None and evader is not None and evader.t_s[0] <= when_s <= evader.t_s[-1]:
        where = evader.at(np.array([when_s])).position_ned_m[0]
        text = f"captured, {when_s - zero_s:.1f} s"
        markers.append(Marker("capture", text, EVADER_COLOUR, (float(where[0]), float(where[1])), True))
    return stretches, markers


def _labels(vehicle: VehicleRun, t_s: Array) -> list[str]:
    """For each time the mode of the newest decision during the pursuit."""
    window = vehicle.phases.window(("pursue",))
    if window is None:
        return [OTHER_LABEL] * len(t_s)
    if vehicle.role == "evader":
        return [EVADER_LABEL if _inside(window, time) else OTHER_LABEL for time in t_s.tolist()]
    decisions = vehicle.recording.topic("/decision")
    modes = decisions.texts("mode")
    newest = np.searchsorted(decisions.t_s, t_s, side="right") - 1
    return [
        (modes[max(index, 0)] if modes else "pursue") if _inside(window, time) else OTHER_LABEL
        for time, index in zip(t_s.tolist(), newest.tolist(), strict=True)
    ]


def _inside(window: Window, t_s: float) -> bool:
    return window.start_s <= t_s < window.end_s


def _perceived(vehicle: VehicleRun) -> list[Array]:
    """The discs of the last frame of the pursuit that showed any."""
    window = vehicle.phases.window(("pursue",))
    series = vehicle.recording.topic("/obstacles")
    for t_s, message in zip(reversed(series.t_s.tolist()), reversed(series.messages), strict=True):
        if (window is None or t_s <= window.end_s) and message.get("discs"):
            return [_circle(*row[:3]) for row in discs_of(message).tolist()]
    return []


def _ways(vehicle: VehicleRun) -> list[Array]:
    """The planned ways that it flew, (n, 2)."""
    return [np.array(message["places_ned_m"])[:, :2] for message in vehicle.recording.topic("/way").messages]


def _known(known: KnownObstacle) -> Array:
    if isinstance(known, KnownBox):
        return _rectangle(known)
    return _circle(known.north_m, known.east_m, known.radius_m)


def _line(vertices_m: tuple[tuple[float, float], ...], closed: bool) -> Array:
    return np.array([*vertices_m, vertices_m[0]] if closed else vertices_m, dtype=np.float64)


def _circle(north_m: float, east_m: float, radius_m: float) -> Array:
    angle = np.linspace(0.0, 2 * math.pi, 41)
    return np.column_stack([north_m + radius_m * np.cos(angle), east_m + radius_m * np.sin(angle)])


def _rectangle(box: Box | KnownBox) -> Array:
    heading = math.radians(box.heading_deg)
    along = np.array([math.cos(heading), math.sin(heading)]) * box.length_m / 2
    across = np.array([-math.sin(heading), math.cos(heading)]) * box.width_m / 2
    centre = np.array([box.north_m, box.east_m])
    corners = [centre + along + across, centre + along - across, centre - along - across, centre - along + across]
    return np.array([*corners, corners[0]])

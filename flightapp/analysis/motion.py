"""Figures of motion: lengths, jerk, closest approaches, clearance to the true world. Metres and seconds, mission frame."""

from __future__ import annotations

import numpy as np

from flightapp.analysis.track import Track
from flightapp.core.clearance import NO_OBSTACLE_M
from flightapp.core.types import Array, Boundary
from flightapp.recording.phases import Window
from flightapp.sim.world import World

_JERK_STEP_S = 0.2
_JERK_FINE_STEPS = 5
_STRETCH = 16
"""Samples of a track that are judged together before they are looked at one by one."""


def path_length_m(track: Track) -> float:
    """Length of the way flown, in three dimensions."""
    return float(np.linalg.norm(np.diff(track.position_ned_m, axis=0), axis=1).sum())


def mean_jerk_m_s3(track: Track) -> float | None:
    """Mean size of the jerk; None for less than 0.6 s."""
    _, jerk = jerk_m_s3(track)
    return float(jerk.mean()) if len(jerk) else None


def jerk_m_s3(track: Track) -> tuple[Array, Array]:
    """Times (n,) and size (n,) of the jerk: second differences of the velocity averaged over 0.2 s, so that noise is no jerk.

    Nothing for less than 0.6 s.
    """
    fine_s = _JERK_STEP_S / _JERK_FINE_STEPS
    count = int((track.t_s[-1] - track.t_s[0]) / fine_s) if len(track) else 0
    count -= count % _JERK_FINE_STEPS
    if count < 3 * _JERK_FINE_STEPS:
        return np.zeros(0), np.zeros(0)
    times = track.t_s[0] + fine_s * np.arange(count)
    mean = track.at(times).velocity_ned_m_s.reshape(-1, _JERK_FINE_STEPS, 3).mean(axis=1)
    jerk = np.diff(mean, n=2, axis=0) / _JERK_STEP_S**2
    middle = times.reshape(-1, _JERK_FINE_STEPS).mean(axis=1)[1:-1]
    return middle, np.linalg.norm(jerk, axis=1)


def min_distance_m(first: Track, second: Track, window: Window) -> tuple[float, float] | None:
    """Smallest distance of the centres within `window` and its time, also between samples; None without common time.

    Both tracks are straight between samples; on the union of their times the relative motion is straight as well.
    """
    if len(first) < 2 or len(second) < 2:
        return None
    spans = [Window(float(track.t_s[0]), float(track.t_s[-1])) for track in (first, second)]
    common = window.common(spans[0])
    common = None if common is None else common.common(spans[1])
    if common is None:
        return None
    times = np.union1d(first.within(common).t_s, second.within(common).t_s)
    relative = second.at(times).position_ned_m - first.at(times).position_ned_m
    step = np.diff(relative, axis=0)
    length = (step**2).sum(axis=1)
    fraction = np.clip(-(relative[:-1] * step).sum(axis=1) / np.where(length > 0.0, length, 1.0), 0.0, 1.0)
    distances = np.linalg.norm(relative[:-1] + fraction[:, None] * step, axis=1)
    nearest = int(np.argmin(distances))
    return float(distances[nearest]), float(times[nearest] + fraction[nearest] * (times[nearest + 1] - times[nearest]))


def min_clearance_m(track: Track, world: World, body_radius_m: float) -> float | None:
    """Smallest distance of the body's surface to the world along the whole way, at most 1 cm too small; None if unknown."""
    nearest = nearest_obstacle(track, world, body_radius_m)
    return None if nearest is None else nearest[0]


def nearest_obstacle(track: Track, world: World, body_radius_m: float) -> tuple[float, float] | None:
    """The same with its time.

    Where the distance at both ends of a stretch says that the way between them cannot reach a nearer place, nobody looks closer.
    """
    points = track.position_ned_m
    if len(points) < 2:
        return None
    travelled = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
    ends = np.unique(np.append(np.arange(0, len(points), _STRETCH), len(points) - 1))
    distances = np.array([world.signed_distance_m(*points[end].tolist()) for end in ends])
    reachable = (distances[:-1] + distances[1:] - np.diff(travelled[ends])) / 2
    least, at = NO_OBSTACLE_M, 0
    for stretch in np.argsort(reachable):
        if reachable[stretch] >= least:
            break
        for index in range(ends[stretch], ends[stretch + 1]):
            clearance = world.segment_clearance_m(points[index], points[index + 1])
            if clearance < least:
                least, at = clearance, index
    return (least - body_radius_m, float(track.t_s[at])) if least < NO_OBSTACLE_M / 2 else None


def boundary_distances_m(position_ned_m: Array, boundary: Boundary) -> Array:
    """Distance (n,) of points (n, 2 or 3) to the boundary line, planar, never negative."""
    starts = boundary.vertices_m
    ends = np.roll(starts, -1, axis=0)
    if not boundary.closed:
        starts, ends = starts[:-1], ends[:-1]
    points = position_ned_m[:, None, :2]
    edge = ends - starts
    fraction = np.clip(((points - starts) * edge).sum(axis=2) / (edge**2).sum(axis=1), 0.0, 1.0)
    gap = points - (starts + fraction[:, :, None] * edge)
    return np.asarray(np.hypot(gap[:, :, 0], gap[:, :, 1]).min(axis=1))

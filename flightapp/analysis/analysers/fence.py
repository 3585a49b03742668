"""Fence: whether the vehicle left the flight volume, and how near to its edge it came."""

from __future__ import annotations

import numpy as np
import shapely
from shapely.geometry import Polygon

from flightapp.analysis.analysers.analyser import MISSION, PROFILE, Analyser
from flightapp.analysis.analysers.subject import Subject
from flightapp.analysis.findings import Finding, Severity
from flightapp.analysis.track import Track
from flightapp.analysis.ulog.spans import spans_of
from flightapp.core.types import Array

NAME = "fence"
NOISE_M = 0.1
"""What the own position jitters from sample to sample at rest with a good fix: less than that outside is no crossing."""


def examine(subject: Subject) -> list[Finding]:
    track = subject.vehicle.track
    flown = None if track is None or subject.airborne is None else track.within(subject.airborne)
    if flown is None or len(flown) == 0:
        return []
    return [_planar(subject, flown), *_height(subject, flown)]


def _planar(subject: Subject, flown: Track) -> Finding:
    volume = subject.mission.flight_volume
    inside_m = _inside_m(Polygon(volume.vertices_m), flown.position_ned_m)
    nearest = int(np.argmin(inside_m))
    least_m = float(inside_m[nearest])
    evidence: dict[str, float | str] = {"inside_m": least_m, "margin_m": subject.profile.safety.fence_margin_m}
    if least_m >= -NOISE_M:
        text = f"It stayed {max(0.0, least_m):.1f} m inside the flight volume at the nearest."
        when_s = float(flown.t_s[nearest])
        return Finding(NAME, Severity.OK, "inside the fence", text, when_s, when_s, evidence, subject.name)
    own = volume.contingency_vertices_m
    contingency = Polygon(volume.vertices_m).buffer(volume.contingency_m) if own is None else Polygon(own)
    beyond_m = -float(_inside_m(contingency, flown.position_ned_m[nearest : nearest + 1])[0])
    spans = spans_of(flown.t_s, inside_m < -NOISE_M)
    title = "outside the contingency volume" if beyond_m > 0.0 else "outside the flight volume"
    text = f"It was up to {-least_m:.1f} m outside the flight volume" + (
        f" and {beyond_m:.1f} m outside the contingency volume." if beyond_m > 0.0 else ", inside the contingency volume."
    )
    return Finding(NAME, Severity.FAILURE, title, text, spans[0].from_s, spans[-1].to_s, evidence, subject.name)


def _height(subject: Subject, flown: Track) -> list[Finding]:
    """The top all the time, the bottom in the pursuit only: take-off and landing pass it."""
    volume, found = subject.mission.flight_volume, []
    above_m = -flown.position_ned_m[:, 2] - volume.height_max_m
    below_m = volume.height_min_m + flown.position_ned_m[:, 2]
    below_m[_in_offboard(subject, flown.t_s) == 0] = -np.inf
    for over_m, edge, limit_m in ((above_m, "above", volume.height_max_m), (below_m, "below", volume.height_min_m)):
        spans = spans_of(flown.t_s, over_m > NOISE_M)
        if spans:
            most_m = float(over_m.max())
            text = f"It was up to {most_m:.1f} m {edge} the height of {limit_m:g} m."
            evidence: dict[str, float | str] = {"beyond_m": most_m, "limit_m": limit_m}
            title = f"{edge} the height band"
            found.append(Finding(NAME, Severity.FAILURE, title, text, spans[0].from_s, spans[-1].to_s, evidence, subject.name))
    return found


def _in_offboard(subject: Subject, t_s: Array) -> Array:
    pursuit = subject.pursuit
    inside = np.zeros(len(t_s), dtype=bool)
    for span in subject.offboard:
        if pursuit is None:
            break
        inside |= (t_s >= max(span.from_s, pursuit.start_s)) & (t_s <= min(span.to_s, pursuit.end_s))
    return inside


def _inside_m(polygon: Polygon, position_ned_m: Array) -> Array:
    """(n,) distance to the outline, negative outside."""
    points = shapely.points(position_ned_m[:, :2])
    shapely.prepare(polygon)
    sign = np.where(shapely.covers(polygon, points), 1.0, -1.0)
    return np.asarray(sign * shapely.distance(polygon.exterior, points))


ANALYSER = Analyser(NAME, "Did it stay inside the flight volume?", ("/own", MISSION, PROFILE), examine)

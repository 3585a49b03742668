"""One frame as JSON, as a table and as one line of text."""

from __future__ import annotations

import json
import math
from typing import TypedDict

from perception.view.picture import health_line
from perception.view.shot import Shot, bearing_rad, gap_m, off_axis_rad


class DiscRow(TypedDict):
    """north_m, east_m: of the centre in the mission frame. distance_m: from the camera to the front. bearing_deg: clockwise
    from north as seen from the camera; off_axis_deg: to the right of the camera's heading. age_s: since it was last seen."""

    number: int
    north_m: float | None
    east_m: float | None
    radius_m: float | None
    distance_m: float | None
    bearing_deg: float | None
    off_axis_deg: float | None
    velocity_north_m_s: float | None
    velocity_east_m_s: float | None
    age_s: float | None
    confidence: float | None


class HealthRow(TypedDict):
    """State of the source, its counters since it was opened, and times of perception."""

    received: int
    skipped: int
    lost: int
    restarts: int
    temperature_c: float | None
    fault: str
    rate_hz: float | None
    computing_ms: float | None
    latency_ms: float | None


class FrameRow(TypedDict):
    """One line of JSON. unseen_deg: bearings [from, to) clockwise from north. A number that is not finite is null."""

    name: str
    number: int
    t_s: float | None
    picture: str | None
    discs: list[DiscRow]
    unseen_deg: list[list[float | None]]
    events: list[str]
    health: HealthRow


def frame_row(shot: Shot, picture: str | None) -> FrameRow:
    """picture: the file that the frame's picture was written to."""
    health, timing = shot.health, shot.timing
    return FrameRow(
        name=shot.name,
        number=shot.frame.number,
        t_s=_rounded(shot.frame.t_s, 6),
        picture=picture,
        discs=[_disc_row(shot, i) for i in range(len(shot.obstacles.discs))],
        unseen_deg=[[_rounded(math.degrees(bearing), 1) for bearing in sector] for sector in shot.obstacles.unseen],
        events=list(shot.obstacles.events),
        health=HealthRow(
            received=health.received,
            skipped=health.skipped,
            lost=health.lost,
            restarts=health.restarts,
            temperature_c=health.temperature_c,
            fault=health.fault,
            rate_hz=_rounded(timing.rate_hz, 2),
            computing_ms=_rounded(1e3 * timing.process_s, 3),
            latency_ms=None if timing.latency_s is None else _rounded(1e3 * timing.latency_s, 3),
        ),
    )


def as_json(row: FrameRow) -> str:
    return json.dumps(row, allow_nan=False)


def as_table(row: FrameRow) -> str:
    lines = [row["name"] + (f"  ->  {row['picture']}" if row["picture"] else "")]
    lines.extend(f"  ! {event}" for event in row["events"])
    if not row["discs"]:
        return "\n".join([*lines, "    no obstacle"])
    lines.append("     no.  distance_m  off_axis_deg  north_m  east_m  radius_m  speed_m_s  age_s  confidence")
    for disc in row["discs"]:
        speed = math.hypot(disc["velocity_north_m_s"] or 0.0, disc["velocity_east_m_s"] or 0.0)
        lines.append(
            f"    {disc['number']:4d}  {_cell(disc['distance_m'], 10, 2)}  {_cell(disc['off_axis_deg'], 12, 1)}"
            f"  {_cell(disc['north_m'], 7, 2)}  {_cell(disc['east_m'], 6, 2)}  {_cell(disc['radius_m'], 8, 2)}"
            f"  {speed:9.2f}  {_cell(disc['age_s'], 5, 2)}  {_cell(disc['confidence'], 10, 2)}"
        )
    return "\n".join(lines)


def as_line(shot: Shot) -> str:
    """For a stream: one line now and then."""
    discs = shot.obstacles.discs
    nearest = min((gap_m(disc, shot.camera) for disc in discs), default=math.inf)
    found = f"{len(discs):2d} discs, nearest {nearest:.2f} m" if len(discs) else "no obstacle"
    events = "".join(f"   ! {event}" for event in shot.obstacles.events)
    return f"{shot.name}   t {shot.frame.t_s:.1f} s   {found}   {health_line(shot)}{events}"


def _disc_row(shot: Shot, i: int) -> DiscRow:
    disc = shot.obstacles.discs[i]
    return DiscRow(
        number=i + 1,
        north_m=_rounded(disc[0], 3),
        east_m=_rounded(disc[1], 3),
        radius_m=_rounded(disc[2], 3),
        distance_m=_rounded(gap_m(disc, shot.camera), 3),
        bearing_deg=_rounded(math.degrees(bearing_rad(disc, shot.camera)), 1),
        off_axis_deg=_rounded(math.degrees(off_axis_rad(disc, shot.camera)), 1),
        velocity_north_m_s=_rounded(disc[3], 3),
        velocity_east_m_s=_rounded(disc[4], 3),
        age_s=_rounded(shot.obstacles.age_s[i], 3),
        confidence=_rounded(shot.obstacles.confidence[i], 3),
    )


def _rounded(number: float, digits: int) -> float | None:
    return round(float(number), digits) if math.isfinite(number) else None


def _cell(number: float | None, width: int, digits: int) -> str:
    return f"{'-':>{width}}" if number is None else f"{number:{width}.{digits}f}"

"""The hunt as the leader plans it, and as everybody does alone where nobody leads: a pure function of what is known.

Base point on the target's predicted path, a polygon of slots around it, and who takes which (sections 2.11 to 2.14 of the
specification, Li et al. 2025). Everything is in the mission frame, planar, angles clockwise from north.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from flightapp.core.types import Array, Limits
from flightapp.planning.hunting.parameters import HuntingParameters
from flightapp.planning.meeting import MEETING_MIN, Meeting, Runners, meeting_of
from flightapp.planning.polygon import Bodies, assign_slots, free_ring, places_on_ring_m
from flightapp.planning.prediction import Fit, Path, predicted_path

PATH_STEPS = 400
PATH_STEP_MIN_S = 0.1
HORIZON_MIN_S = 10.0
EARLIER_SHARE = 0.9
"""Of the time left: a meeting earlier than this is worth a change."""
MOVED_SHARE = 0.5
"""Of the hunting radius: the meeting in force moves along with the prediction up to this far a plan."""
LEFT_RATIO = 1.5
"""Of the distance at which the ring closes: further away than this a hunter has left it."""
LATE_MAX_S = 3.0
"""Who is no later than this at its slot is in time: the ring still closes."""


@dataclass(frozen=True, slots=True)
class Hunter:
    """One that takes part."""

    name: str
    place_m: tuple[float, float]
    heading_rad: float
    speed_m_s: float
    speed_max_m_s: float


@dataclass(frozen=True, slots=True)
class Rules:
    """What a plan needs of the team: all vehicles are alike but for their top speed."""

    bodies: Bodies
    radius_m: float
    acceleration_m_s2: float
    turn_rate_max_rad_s: float
    turn_acceleration_rad_s2: float
    target_speed_max_m_s: float
    horizon_max_s: float
    close_ratio: float
    freeze_s: float


def rules_of(parameters: HuntingParameters, limits: Limits) -> Rules:
    """As `parameters` say for vehicles with `limits`."""
    separation_m = parameters.separation_m or 2.5 * limits.body_radius_m
    return Rules(
        bodies=Bodies(limits.body_radius_m, parameters.evader_radius_m, separation_m),
        radius_m=parameters.hunting_radius_m or parameters.capture.slot_radius_m,
        acceleration_m_s2=limits.acceleration_max_m_s2,
        turn_rate_max_rad_s=limits.yaw_rate_max_rad_s,
        turn_acceleration_rad_s2=limits.yaw_acceleration_max_rad_s2,
        target_speed_max_m_s=parameters.evader_speed_assumed_m_s,
        horizon_max_s=parameters.plan_horizon_max_s,
        close_ratio=parameters.close_ratio,
        freeze_s=parameters.freeze_s,
    )


@dataclass(frozen=True, slots=True)
class Place:
    """One hunter's part."""

    bearing_rad: float
    """Of its slot, seen from the base point."""
    place_m: tuple[float, float]
    alone_s: float
    """When it is there at the earliest, fleet time."""
    slot: int
    """Below 0: it trails the target, because it cannot be in time or no slot is free; -1 is the first behind it."""


@dataclass(frozen=True, slots=True)
class Hunt:
    """A plan: `base_m` is met at `meeting_s` (fleet time), the target then moving along `heading_rad`."""

    base_m: tuple[float, float]
    radius_m: float
    heading_rad: float
    meeting_s: float
    slots: int
    closing: bool
    """The ring is around the target and moves with it; nobody changes slots any more."""
    reachable: bool
    """Three of the team can be in time, or all where there are fewer; else the base point is where it is least late."""
    places: Mapping[str, Place] = field(default_factory=dict)


def plan_hunt(
    now_s: float,
    target_m: tuple[float, float],
    target_course_rad: float,
    fit: Fit | None,
    hunters: tuple[Hunter, ...],
    discs: Array,
    rules: Rules,
    before: Hunt | None,
) -> Hunt:
    """The plan for `hunters` (at least one, in the order of names). discs: (m, >=3) standing obstacles.

    target_course_rad: its course, which counts where the prediction does not move.
    """
    target = np.array(target_m)
    runners = _runners(hunters, rules)
    starts = runners.places_m
    path = _path(now_s, target, fit, runners, rules)
    distances = np.hypot(*(starts - target).T)
    is_same_team = before is not None and set(before.places) == {hunter.name for hunter in hunters}
    close_m = rules.close_ratio * rules.bodies.ring_radius_m(len(hunters), rules.radius_m)
    is_near = bool((distances <= close_m).all())
    if before is not None and is_same_team and (is_near or _stays_closed(now_s, before, distances, close_m)):
        return _closed(now_s, target, runners, hunters, before)
    meeting = _steady(now_s, meeting_of(runners, path), path, runners, hunters, before if is_same_team else None)
    base = path.places_m[meeting.index]
    heading = path.heading_rad(meeting.index)
    heading = target_course_rad if heading is None else heading
    meeting_s = now_s + meeting.index * path.step_s
    in_time = [k for k in range(len(hunters)) if not meeting.late[k]]
    ring = free_ring(base, heading, len(in_time), rules.radius_m, rules.bodies, discs)
    names = [hunters[k].name for k in in_time]
    slots_before = _slots_of(before) if is_same_team and before is not None and before.slots == len(ring.places_m) else {}
    frozen = is_near or meeting_s - now_s < rules.freeze_s
    if frozen and slots_before and all(name in slots_before for name in names):
        chosen: list[int | None] = [slots_before[name] for name in names]
    else:
        chosen = assign_slots(starts[in_time], ring.places_m, names, slots_before)
    places = {}
    for name, k, slot in zip(names, in_time, chosen, strict=True):
        if slot is not None:
            place = ring.places_m[slot]
            alone_s = now_s + float(runners.times_s(place[None])[k, 0])
            places[name] = Place(float(ring.bearings_rad[slot]), (float(place[0]), float(place[1])), alone_s, slot)
    left = [k for k in range(len(hunters)) if hunters[k].name not in places]
    for rank, k in enumerate(sorted(left, key=lambda k: (distances[k], hunters[k].name))):
        places[hunters[k].name] = _trailing(now_s, base, heading, ring.radius_m, -1 - rank, runners, k)
    return Hunt(
        (float(base[0]), float(base[1])),
        ring.radius_m,
        heading,
        meeting_s,
        len(ring.places_m),
        is_near,
        meeting.reachable,
        places,
    )


def trailing_hunt(
    now_s: float, target_m: tuple[float, float], target_course_rad: float, hunters: tuple[Hunter, ...], rules: Rules
) -> Hunt:
    """All behind the target, the nearest first: what those do who hear no majority of the team.

    Whoever holds the ring without being heard leaves the stern free: slots of an odd number are beside it, of an even one, too.
    """
    target, radius_m = np.array(target_m), rules.bodies.ring_radius_m(1, rules.radius_m)
    runners = _runners(hunters, rules)
    order = sorted(range(len(hunters)), key=lambda k: (math.dist(hunters[k].place_m, target_m), hunters[k].name))
    places = {
        hunters[k].name: _trailing(now_s, target, target_course_rad, radius_m, -1 - rank, runners, k)
        for rank, k in enumerate(order)
    }
    return Hunt(target_m, radius_m, target_course_rad, now_s, 1, closing=True, reachable=True, places=places)


def _runners(hunters: tuple[Hunter, ...], rules: Rules) -> Runners:
    return Runners(
        np.array([hunter.place_m for hunter in hunters]),
        np.array([hunter.heading_rad for hunter in hunters]),
        np.array([hunter.speed_m_s for hunter in hunters]),
        np.array([hunter.speed_max_m_s for hunter in hunters]),
        rules.acceleration_m_s2,
        rules.turn_rate_max_rad_s,
        rules.turn_acceleration_rad_s2,
    )


def _stays_closed(now_s: float, before: Hunt, distances: Array, close_m: float) -> bool:
    """Whether the ring is or goes on being around the target, also while a minority is not: it is on its way."""
    near = int((distances <= LEFT_RATIO * close_m).sum())
    return (before.closing or now_s >= before.meeting_s) and near >= min(
        len(distances), max(MEETING_MIN, len(distances) // 2 + 1)
    )


def _steady(
    now_s: float, best: Meeting, path: Path, runners: Runners, hunters: tuple[Hunter, ...], before: Hunt | None
) -> Meeting:
    """The meeting in force, as long as the prediction leads there and all who are to meet are in time, or `best`.

    A margin that is added anew in every plan moves the meeting away as fast as an equally fast team flies.
    """
    if before is None or before.closing or best.index * path.step_s < EARLIER_SHARE * (before.meeting_s - now_s):
        return best
    index = round((before.meeting_s - now_s) / path.step_s)
    if not 0 < index < len(path.places_m) or math.dist(path.places_m[index], before.base_m) > MOVED_SHARE * before.radius_m:
        return best
    shift = path.places_m[index] - np.array(before.base_m)
    late = np.array([before.places[hunter.name].slot < 0 for hunter in hunters])
    slots = np.array([before.places[hunter.name].place_m for hunter in hunters]) + shift
    lateness = np.diagonal(runners.times_s(slots)) - index * path.step_s
    return Meeting(index, late, True) if (lateness[~late] <= LATE_MAX_S).all() else best


def _path(now_s: float, target: Array, fit: Fit | None, runners: Runners, rules: Rules) -> Path:
    """As far ahead as a meeting can be."""
    longest_s = float((np.hypot(*(runners.places_m - target).T) / runners.speeds_max_m_s).max())
    horizon_s = min(rules.horizon_max_s, max(HORIZON_MIN_S, 3.0 * longest_s))
    step_s = max(PATH_STEP_MIN_S, horizon_s / PATH_STEPS)
    return predicted_path(fit, target, now_s, step_s, math.ceil(horizon_s / step_s), rules.target_speed_max_m_s)


def _slots_of(hunt: Hunt) -> dict[str, int]:
    return {name: place.slot for name, place in hunt.places.items() if place.slot >= 0}


def away_m(radius_m: float, slot: int) -> float:
    """How far from the ring's centre a slot is: who trails is a radius further behind than the one before."""
    return radius_m if slot >= 0 else radius_m * (1.0 - slot)


def _trailing(now_s: float, base: Array, heading: float, radius_m: float, slot: int, runners: Runners, k: int) -> Place:
    place = places_on_ring_m(base, away_m(radius_m, slot), np.array([heading + math.pi]))
    alone_s = now_s + float(runners.times_s(place)[k, 0])
    return Place(heading + math.pi, (float(place[0, 0]), float(place[0, 1])), alone_s, slot)


def _closed(now_s: float, target: Array, runners: Runners, hunters: tuple[Hunter, ...], before: Hunt) -> Hunt:
    """The same ring around the target where it is now, for those on slots; who trailed and is near fills in when it re-forms."""
    places = {}
    for k, hunter in enumerate(hunters):
        old = before.places[hunter.name]
        place = places_on_ring_m(target, away_m(before.radius_m, old.slot), np.array([old.bearing_rad]))
        alone_s = now_s + float(runners.times_s(place)[k, 0])
        places[hunter.name] = Place(old.bearing_rad, (float(place[0, 0]), float(place[0, 1])), alone_s, old.slot)
    return Hunt(
        (float(target[0]), float(target[1])), before.radius_m, before.heading_rad, now_s, before.slots, True, True, places
    )

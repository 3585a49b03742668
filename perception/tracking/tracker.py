"""Discs over frames: one thing stays one disc, what moves has a velocity, what left the view is remembered."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from perception.parameters import PerceptionParameters
from perception.sighting import Sighting
from perception.tracking.association import NEW, associate, reconcile
from perception.tracking.motion import correct, predict, start
from perception.tracking.sight import look
from perception.tracking.tracks import TRACK, Records, rules_of

TRACKS_MAX = 300
_PAIRS_MAX = 4 * TRACKS_MAX
_LATE_MAX_S = 0.2
"""A frame older than the newest by less than this comes late; by more, the clock was set back."""
_BETWEEN_FRAMES_S = 0.3
"""Tracks are kept for this long even if nothing is to be remembered, or else nothing could prove to move."""
_ESTABLISHED_S = 1.0
"""What stood still for so long outlives an exclusion that covers it."""
_CONFIRMED_HITS = 3
"""A disc that was seen so often is forgotten only after so many frames that look through it; one seen once, at once."""


@dataclass(frozen=True, slots=True)
class TrackedDiscs:
    """Discs in the mission frame at the time of the newest frame.

    discs: (n, 5) north_m, east_m, radius_m, v_north_m_s, v_east_m_s; the velocity is zero unless movement is proven.
    age_s: (n,) since each was last seen. confidence: (n,) in [0, 1]; half that of the sighting at first, more with every frame
    that confirms it, less with age.
    """

    discs: NDArray[np.float64]
    age_s: NDArray[np.float64]
    confidence: NDArray[np.float64]


class DiscTracker:
    """Tracks of one vehicle's camera. Not safe for use from two threads at once; bounded in memory; never raises.

    Time: frames are expected in order. One that is not newer than the newest is used for nothing, unless it is older by more
    than 0.2 s: then the clock was set back, all times kept here move with it, and nothing is forgotten for it. A frame whose
    time is not a number is used for nothing either.
    """

    def __init__(self, parameters: PerceptionParameters) -> None:
        self._parameters = parameters
        self._rules = rules_of(parameters)
        self._tracks = np.zeros(TRACKS_MAX, TRACK)
        self._costs = np.zeros(_PAIRS_MAX)
        self._pairs = np.zeros((_PAIRS_MAX, 2), np.int64)
        self.clear()

    def clear(self) -> None:
        """Forget everything."""
        self._count = 0
        self._newest_s = -math.inf

    def update(self, t_s: float, sighting: Sighting | None, exclude: NDArray[np.float64]) -> TrackedDiscs:
        """Discs after the frame of time `t_s`.

        sighting: what it showed, None if it showed nothing. exclude: (k, 3) north_m, east_m, radius_m of teammates and the
        target; no disc is reported whose centre lies in one, and only what stood there before them is remembered.
        """
        is_late = self._is_late(t_s)
        if not is_late:
            self._newest_s = t_s
            self._expire()
        tracks = self._tracks[: self._count]
        predict(tracks, self._newest_s, self._rules)
        self._withhold(exclude)
        if sighting is not None and not is_late:
            self._see(_usable(sighting, exclude))
        return self._report()

    def _is_late(self, t_s: float) -> bool:
        """Whether a frame of this time is of no use; moves all times if the clock was set back."""
        if not math.isfinite(t_s):
            return True
        back_s = self._newest_s - t_s
        if back_s <= _LATE_MAX_S:
            return back_s >= 0
        tracks = self._tracks[: self._count]
        for field in ("updated_s", "first_s", "seen_s", "anchor_s"):
            tracks[field] -= back_s
        return False

    def _expire(self) -> None:
        """Drop tracks that were not seen for too long; moving ones sooner, and counted from when they were seen as a whole."""
        tracks = self._tracks[: self._count]
        memory_s = max(self._parameters.memory_s, _BETWEEN_FRAMES_S)
        moving_s = min(memory_s, max(self._parameters.memory_moving_s, _BETWEEN_FRAMES_S))
        is_moving = tracks["is_moving"] == 1
        keep = self._newest_s - tracks["seen_s"] <= memory_s
        keep &= ~is_moving | (self._newest_s - tracks["updated_s"] <= moving_s)
        self._keep(keep)

    def _withhold(self, exclude: NDArray[np.float64]) -> None:
        """Mark tracks inside an exclusion; drop them unless they stood there for some time."""
        tracks = self._tracks[: self._count]
        if not len(exclude) or not self._count:
            tracks["is_withheld"] = 0
            return
        inside = _is_inside(tracks["now_north_m"], tracks["now_east_m"], exclude)
        tracks["is_withheld"] = inside
        is_established = (tracks["is_moving"] == 0) & (tracks["seen_s"] - tracks["first_s"] >= _ESTABLISHED_S)
        self._keep(~inside | is_established)

    def _see(self, sighting: Sighting) -> None:
        """Bring the tracks up to date with what was seen."""
        t_s, rules, tracks = self._newest_s, self._rules, self._tracks[: self._count]
        discs, view = sighting.discs, sighting.view
        camera_north, camera_east = float(view.camera.position_ned_m[0]), float(view.camera.position_ned_m[1])
        track_of, is_isolated = np.empty(len(discs), np.int64), np.empty(len(discs), np.bool_)
        associate(
            tracks,
            t_s,
            discs,
            sighting.sigma_m,
            sighting.is_whole,
            camera_north,
            camera_east,
            rules,
            self._costs,
            self._pairs,
            track_of,
            is_isolated,
        )
        correct(
            tracks, t_s, discs, sighting.sigma_m, sighting.confidence, track_of, is_isolated, camera_north, camera_east, rules
        )
        known = np.column_stack([tracks["now_north_m"], tracks["now_east_m"], tracks["radius_m"]])
        known_sigma_m = np.sqrt(np.maximum(tracks["now_covariance"][:, 0, 0], tracks["now_covariance"][:, 1, 1]))
        track_in_view, seen_through = look(view, known, known_sigma_m, self._parameters.surface_tolerance_m)
        disc_in_view, _ = look(view, discs, sighting.sigma_m, self._parameters.surface_tolerance_m)
        heir_of = np.empty(len(tracks), np.int64)
        reconcile(
            tracks,
            t_s,
            discs,
            sighting.sigma_m,
            sighting.confidence,
            sighting.is_whole,
            disc_in_view,
            track_in_view,
            camera_north,
            camera_east,
            rules,
            track_of,
            heir_of,
        )
        tracks["seen_through"] += seen_through & (tracks["seen_s"] < t_s)
        is_gone = tracks["seen_through"] >= np.clip(tracks["hits"], 1, _CONFIRMED_HITS)
        added = self._added(sighting, np.flatnonzero(track_of == NEW), heir_of)
        self._keep((heir_of < 0) & ~is_gone)
        self._append(added)

    def _added(self, sighting: Sighting, new: NDArray[np.intp], heir_of: NDArray[np.int64]) -> Records:
        """Tracks of the sighted discs `new`; each inherits how well known was what gives way to it."""
        camera = sighting.view.camera.position_ned_m
        added = np.zeros(len(new), TRACK)
        start(added, self._newest_s, sighting.discs, sighting.sigma_m, new, float(camera[0]), float(camera[1]), self._rules)
        added["first_s"] = added["seen_s"] = self._newest_s
        added["is_whole"] = sighting.is_whole[new]
        for j in np.flatnonzero(heir_of >= 0):
            k = int(np.searchsorted(new, heir_of[j]))
            if k < len(new) and new[k] == heir_of[j]:
                before = self._tracks[j]
                added["hits"][k] = max(added["hits"][k], before["hits"])
                added["confidence"][k] = max(added["confidence"][k], before["confidence"])
                added["first_s"][k] = min(added["first_s"][k], before["first_s"])
        added["hits"] += 1
        added["confidence"] = 1 - (1 - added["confidence"]) * (1 - sighting.confidence[new] / 2)
        return added

    def _append(self, added: Records) -> None:
        """Add tracks; where there is no room, those that were seen longest ago and least surely make way."""
        if self._count + len(added) > TRACKS_MAX:
            tracks = self._tracks[: self._count]
            worth = np.lexsort((tracks["confidence"], tracks["seen_s"]))
            keep = np.zeros(self._count, np.bool_)
            room = TRACKS_MAX - min(len(added), TRACKS_MAX)
            keep[worth[self._count - room :]] = True
            self._keep(keep)
        self._tracks[self._count : self._count + len(added)] = added
        self._count += len(added)

    def _keep(self, keep: NDArray[np.bool_]) -> None:
        if not keep.all():
            kept = self._tracks[: self._count][keep]
            self._count = len(kept)
            self._tracks[: self._count] = kept

    def _report(self) -> TrackedDiscs:
        """What is known, without what is withheld or older than the memory allows."""
        tracks = self._tracks[: self._count]
        age_s = self._newest_s - tracks["seen_s"]
        shown = (tracks["is_withheld"] == 0) & (age_s <= self._parameters.memory_s)
        tracks, age_s = tracks[shown], age_s[shown]
        is_moving = tracks["is_moving"] == 1
        discs = np.zeros((len(tracks), 5))
        discs[:, 0] = np.where(is_moving, tracks["now_north_m"], tracks["north_m"])
        discs[:, 1] = np.where(is_moving, tracks["now_east_m"], tracks["east_m"])
        growth_m_s = np.where(is_moving, self._parameters.memory_growth_moving_m_s, self._parameters.memory_growth_m_s)
        discs[:, 2] = tracks["radius_m"] + growth_m_s * age_s
        discs[:, 3] = np.where(is_moving, tracks["v_north_m_s"], 0.0)
        discs[:, 4] = np.where(is_moving, tracks["v_east_m_s"], 0.0)
        fades_s = np.where(is_moving, self._parameters.memory_moving_s, self._parameters.memory_s)
        left = 1 - age_s / np.maximum(fades_s, _BETWEEN_FRAMES_S)
        return TrackedDiscs(discs, age_s, tracks["confidence"] * np.clip(left, 0.0, 1.0))


def _usable(sighting: Sighting, exclude: NDArray[np.float64]) -> Sighting:
    """The finite discs outside every exclusion, at most as many as can be kept, nearest first."""
    discs = sighting.discs
    wanted = np.isfinite(discs).all(axis=1)
    if len(exclude):
        wanted &= ~_is_inside(discs[:, 0], discs[:, 1], exclude)
    chosen = np.flatnonzero(wanted)
    if len(chosen) > TRACKS_MAX:
        camera = sighting.view.camera.position_ned_m
        gap = np.hypot(discs[chosen, 0] - camera[0], discs[chosen, 1] - camera[1]) - discs[chosen, 2]
        chosen = chosen[np.argsort(gap, kind="stable")[:TRACKS_MAX]]
    return Sighting(
        np.ascontiguousarray(discs[chosen], np.float64),
        sighting.sigma_m[chosen],
        sighting.confidence[chosen],
        sighting.is_whole[chosen],
        sighting.view,
    )


def _is_inside(north_m: NDArray[np.float64], east_m: NDArray[np.float64], exclude: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(n,) whether each place lies in one of the circles (k, 3)."""
    gap = np.hypot(north_m[:, None] - exclude[:, 0], east_m[:, None] - exclude[:, 1])
    return np.asarray((gap <= exclude[:, 2]).any(axis=1), np.bool_)

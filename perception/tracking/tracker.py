"""Discs over frames: one thing stays one disc, what moves has a velocity, what left the view is remembered."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from perception.parameters import PerceptionParameters
from perception.sighting import Sighting
from perception.tracking.association import NEW, associate, inherit, reconcile
from perception.tracking.lifetime import compact, outlive, usable, withhold
from perception.tracking.motion import correct, predict, start
from perception.tracking.report import report
from perception.tracking.sight import look
from perception.tracking.tracks import TRACK, Records, rules_of

TRACKS_MAX = 300
_PAIRS_MAX = 4 * TRACKS_MAX
_LATE_MAX_S = 0.2
"""A frame older than the newest by less than this comes late; by more, the clock was set back."""
_BETWEEN_FRAMES_S = 0.3
"""Tracks are kept for this long even if nothing is to be remembered, or else nothing could prove to move."""
_CONFIRMED_HITS = 3
"""A disc that was seen so often is forgotten only after so many frames that look through it; one seen once, at once."""


@dataclass(frozen=True, slots=True)
class TrackedDiscs:
    """Discs in the mission frame at the time of the newest frame.

    discs: (n, 5) north_m, east_m, radius_m, v_north_m_s, v_east_m_s; the velocity is zero unless movement is proven.
    age_s: (n,) since each was last seen. confidence: (n,) in [0, 1]; half that of the sighting at first, more with every frame
    that confirms it, less with age.
    standing: (m, 2) north_m, east_m of what stood for some time where something is to be left out now.
    """

    discs: NDArray[np.float64]
    age_s: NDArray[np.float64]
    confidence: NDArray[np.float64]
    standing: NDArray[np.float64] = dataclasses.field(default_factory=lambda: np.zeros((0, 2)))


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
        self._kept = np.zeros(TRACKS_MAX, np.bool_)
        self._memory_s = max(parameters.memory_s, _BETWEEN_FRAMES_S)
        self._memory_moving_s = min(self._memory_s, max(parameters.memory_moving_s, _BETWEEN_FRAMES_S))
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
        exclude = np.ascontiguousarray(exclude, np.float64)
        is_late = self._is_late(t_s)
        if not is_late:
            self._newest_s = t_s
            kept = self._kept[: self._count]
            outlive(self._tracks[: self._count], t_s, self._memory_s, self._memory_moving_s, kept)
            self._keep(kept)
        predict(self._tracks[: self._count], self._newest_s, self._rules)
        self._withhold(exclude)
        if sighting is not None and not is_late:
            self._see(_usable(sighting, exclude))
            self._withhold(exclude)
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

    def _withhold(self, exclude: NDArray[np.float64]) -> None:
        """Mark tracks inside an exclusion; drop them unless they stood there for some time."""
        kept = self._kept[: self._count]
        withhold(self._tracks[: self._count], self._newest_s, exclude, kept)
        self._keep(kept)

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
        known = np.empty((len(tracks), 3))
        known[:, 0], known[:, 1], known[:, 2] = tracks["now_north_m"], tracks["now_east_m"], tracks["radius_m"]
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
        inherit(self._tracks[: self._count], heir_of, new, sighting.confidence, added)
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
        self._count = compact(self._tracks[: self._count], keep)

    def _report(self) -> TrackedDiscs:
        """What is known, without what is withheld or older than the memory allows."""
        discs, age_s, confidence = np.empty((self._count, 5)), np.empty(self._count), np.empty(self._count)
        shown = report(
            self._tracks[: self._count],
            self._newest_s,
            self._parameters.memory_s,
            self._memory_moving_s,
            self._rules,
            discs,
            age_s,
            confidence,
        )
        withheld = self._tracks[: self._count][self._tracks["is_withheld"][: self._count] == 1]
        standing = np.column_stack([withheld["north_m"], withheld["east_m"]])
        return TrackedDiscs(discs[:shown], age_s[:shown], confidence[:shown], standing)


def _usable(sighting: Sighting, exclude: NDArray[np.float64]) -> Sighting:
    """The finite discs outside every exclusion, at most as many as can be kept, nearest first; all arrays contiguous."""
    discs = np.ascontiguousarray(sighting.discs, np.float64)
    wanted = np.empty(len(discs), np.bool_)
    number = usable(discs, exclude, wanted)
    columns = (discs, sighting.sigma_m, sighting.confidence, sighting.is_whole)
    if number < len(discs):
        chosen = np.flatnonzero(wanted)
        columns = (discs[chosen], sighting.sigma_m[chosen], sighting.confidence[chosen], sighting.is_whole[chosen])
    if number > TRACKS_MAX:
        camera, discs = sighting.view.camera.position_ned_m, columns[0]
        gap = np.hypot(discs[:, 0] - camera[0], discs[:, 1] - camera[1]) - discs[:, 2]
        chosen = np.argsort(gap, kind="stable")[:TRACKS_MAX]
        columns = (discs[chosen], columns[1][chosen], columns[2][chosen], columns[3][chosen])
    return Sighting(
        np.ascontiguousarray(columns[0], np.float64),
        np.ascontiguousarray(columns[1], np.float64),
        np.ascontiguousarray(columns[2], np.float64),
        np.ascontiguousarray(columns[3], np.bool_),
        sighting.view,
    )

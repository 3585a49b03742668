"""Which sighted disc is which known object, and which known discs give way to what is sighted."""

from __future__ import annotations

import math

import numba

from perception.kernel_cache import njit
from perception.tracking.tracks import RULES_TYPE, TRACKS_TYPE

_GATE_SIGMAS = 3.5
_FIRST_STEP_M_S = 5.0
_FIRST_STEP_S = 0.1
"""The gate widens by what something this fast covers in the time since it was seen, at most this long."""
_RADIUS_GATE_M = 0.3
_RADIUS_GATE_FRACTION = 0.5
_ISOLATION_M = 0.3
_SHAPE_SIGMA = 0.1
_POSITION_SIGMA_MIN_M = 0.02
_CONTAINED_M = 0.2
"""A disc that sticks out of another by less than this counts as contained in it."""
_NOISE_SIGMAS = 2.0
_IN_PIECES_S = 0.5
"""An object that was wholly in view for so long without being sighted as one gives way to the pieces that are."""

_CONFIRMED_HITS = 3
"""A piece seen less often, as at the edge of the picture, gives way to a whole object that it touches."""

NEW, KNOWN = -1, -2
"""In place of a track's index: a disc that becomes a track, and one that a track already stands for."""

_F8, _I8, _B1 = numba.types.float64, numba.types.int64, numba.types.boolean
_ASSOCIATE = numba.void(
    TRACKS_TYPE, _F8, _F8[:, ::1], _F8[::1], _B1[::1], _F8, _F8, RULES_TYPE, _F8[::1], _I8[:, ::1], _I8[::1], _B1[::1]
)
_INHERIT = numba.void(TRACKS_TYPE, _I8[::1], _I8[::1], _F8[::1], TRACKS_TYPE)
_RECONCILE = numba.void(
    TRACKS_TYPE,
    _F8,
    _F8[:, ::1],
    _F8[::1],
    _F8[::1],
    _B1[::1],
    _B1[::1],
    _B1[::1],
    _F8,
    _F8,
    RULES_TYPE,
    _I8[::1],
    _I8[::1],
)


@njit(_ASSOCIATE, cache=True, nogil=True, error_model="numpy")
def associate(  # type: ignore[no-untyped-def]
    tracks, t_s, discs, sigma_m, is_whole, camera_north, camera_east, rules, costs, pairs, track_of, is_isolated
):
    """Give whole sighted discs to whole predicted tracks, the closest pair first.

    Close means in standard deviations of the filter and the sighting together, the latter's along and across the line of sight.
    costs: (p,), pairs: (p, 2) work space; pairs beyond it are left out. Out: track_of (m,) index of the track or NEW;
    is_isolated (m,) no other disc is sighted close by.
    """
    rule, found = rules[0], 0
    for i in range(discs.shape[0]):
        track_of[i] = NEW
        is_isolated[i] = True
        if not is_whole[i]:
            continue
        for k in range(discs.shape[0]):
            north, east, reach = discs[i, 0] - discs[k, 0], discs[i, 1] - discs[k, 1], discs[i, 2] + discs[k, 2] + _ISOLATION_M
            if k != i and north * north + east * east < reach * reach:
                is_isolated[i] = False
                break
        sight_north, sight_east = discs[i, 0] - camera_north, discs[i, 1] - camera_east
        distance = max(math.hypot(sight_north, sight_east), 1e-6)
        cos, sin = sight_north / distance, sight_east / distance
        least = _POSITION_SIGMA_MIN_M**2 + (_SHAPE_SIGMA * discs[i, 2]) ** 2
        along = sigma_m[i] ** 2 + least
        across = (math.radians(rule.bearing_error_deg) * distance) ** 2 + least
        furthest = rule.association_m + 2.0 * math.sqrt(max(along, across)) + _FIRST_STEP_M_S * _FIRST_STEP_S
        for j in range(tracks.shape[0]):
            track = tracks[j]
            north, east = discs[i, 0] - track.now_north_m, discs[i, 1] - track.now_east_m
            if abs(north) > furthest or abs(east) > furthest or track.is_whole == 0 or track.is_withheld == 1:
                continue
            step = _FIRST_STEP_M_S * min(t_s - track.updated_s - _FIRST_STEP_S, 0.0)
            if math.hypot(north, east) > furthest + step:
                continue
            larger = max(track.radius_m, discs[i, 2])
            if abs(track.radius_m - discs[i, 2]) > _RADIUS_GATE_M + _RADIUS_GATE_FRACTION * larger:
                continue
            s_nn = track.now_covariance[0, 0] + along * cos * cos + across * sin * sin
            s_ne = track.now_covariance[0, 1] + (along - across) * cos * sin
            s_ee = track.now_covariance[1, 1] + along * sin * sin + across * cos * cos
            cost = (north * north * s_ee - 2.0 * north * east * s_ne + east * east * s_nn) / (s_nn * s_ee - s_ne * s_ne)
            if cost > _GATE_SIGMAS**2 or found == costs.shape[0]:
                continue
            place = found
            while place > 0 and costs[place - 1] > cost:
                costs[place] = costs[place - 1]
                pairs[place, 0], pairs[place, 1] = pairs[place - 1, 0], pairs[place - 1, 1]
                place -= 1
            costs[place], pairs[place, 0], pairs[place, 1] = cost, i, j
            found += 1
    for k in range(found):
        i, j = pairs[k, 0], pairs[k, 1]
        if track_of[i] == NEW and tracks[j].seen_s < t_s:
            track_of[i] = j
            tracks[j].seen_s = t_s


@njit("f8(f8,f8,f8,f8,f8)", cache=True, nogil=True, error_model="numpy")
def _gap_m(north, east, sight_north, sight_east, sigma):  # type: ignore[no-untyped-def]
    """Distance between a track and a sighted disc, less along the line of sight what depth noise explains."""
    distance = max(math.hypot(sight_north, sight_east), 1e-6)
    along = abs(north * sight_north + east * sight_east) / distance
    across = (north * sight_east - east * sight_north) / distance
    return math.hypot(max(along - _NOISE_SIGMAS * sigma, 0.0), across)


@njit(_RECONCILE, cache=True, nogil=True, error_model="numpy")
def reconcile(  # type: ignore[no-untyped-def]
    tracks, t_s, discs, sigma_m, confidence, is_whole, disc_in_view, track_in_view, camera_north, camera_east, rules,
    track_of, heir_of,
):  # fmt: skip
    """Settle what association left over, so that one thing has one disc.

    A track that an observed disc contains gives way to it; so does one wholly in view that lies close to a disc which is not
    known otherwise, and a glimpse that touches a whole object. A disc cut off by the edge of the view, or a part of an object,
    that lies in what a track already covers becomes KNOWN and the track counts as seen. Out: track_of (m,) NEW or KNOWN where
    there is no track; heir_of (n,) index of the disc that each track gives way to, -1 where it stays.
    """
    rule = rules[0]
    for j in range(tracks.shape[0]):
        heir_of[j] = -1
        track = tracks[j]
        if track.seen_s == t_s:
            continue
        in_pieces = track.is_whole == 0 or t_s - track.updated_s > _IN_PIECES_S
        now_north, now_east = track.now_north_m, track.now_east_m
        reach = track.radius_m + rule.association_m + _CONTAINED_M
        for i in range(discs.shape[0]):
            north, east = discs[i, 0] - now_north, discs[i, 1] - now_east
            furthest = reach + discs[i, 2] + _NOISE_SIGMAS * sigma_m[i]
            if abs(north) > furthest or abs(east) > furthest:
                continue
            gap = _gap_m(north, east, discs[i, 0] - camera_north, discs[i, 1] - camera_east, sigma_m[i])
            growth = discs[i, 2] - track.radius_m
            is_new = track_of[i] == NEW
            is_fuller = growth >= 0.0 or (disc_in_view[i] and (is_whole[i] or track.is_whole == 0))
            gives_way = gap <= growth + _CONTAINED_M and is_fuller and (is_new or track.is_moving == 0)
            if track_in_view[j] and is_new and track.is_moving == 0 and (in_pieces or is_whole[i]):
                gives_way |= gap <= rule.association_m + max(growth, 0.0)
            if track_in_view[j] and is_whole[i] and track.is_whole == 0 and track.hits < _CONFIRMED_HITS:
                gives_way |= gap <= discs[i, 2] + track.radius_m
            if gives_way:
                heir_of[j] = i
                break
    for i in range(discs.shape[0]):
        if track_of[i] != NEW:
            continue
        for j in range(tracks.shape[0]):
            track = tracks[j]
            if heir_of[j] >= 0 or track.is_withheld == 1:
                continue
            if disc_in_view[i] and (track.is_whole == 0 or is_whole[i]):
                continue
            north, east = discs[i, 0] - track.now_north_m, discs[i, 1] - track.now_east_m
            furthest = track.now_radius_m + _CONTAINED_M + _NOISE_SIGMAS * sigma_m[i]
            if abs(north) > furthest or abs(east) > furthest:
                continue
            gap = _gap_m(north, east, discs[i, 0] - camera_north, discs[i, 1] - camera_east, sigma_m[i])
            # A moving one may be anywhere in its grown disc; but then it was not seen where it is, and stays as large.
            radius_m = track.radius_m if track.is_moving == 0 else track.now_radius_m
            if gap <= _CONTAINED_M + radius_m - discs[i, 2]:
                track_of[i] = KNOWN
                if track.seen_s < t_s and gap <= _CONTAINED_M + track.radius_m - discs[i, 2]:
                    track.seen_s, track.seen_through = t_s, 0
                    track.hits += 1
                    track.confidence = 1.0 - (1.0 - track.confidence) * (1.0 - confidence[i] / 2)
                break


@njit(_INHERIT, cache=True, nogil=True, error_model="numpy")
def inherit(tracks, heir_of, new, confidence, added):  # type: ignore[no-untyped-def]
    """Fill in how well known are the tracks `added` of the sighted discs `new`, from the tracks that gave way to them."""
    for j in range(tracks.shape[0]):
        if heir_of[j] < 0:
            continue
        for k in range(new.shape[0]):
            if new[k] == heir_of[j]:
                added[k].hits = max(added[k].hits, tracks[j].hits)
                added[k].confidence = max(added[k].confidence, tracks[j].confidence)
                added[k].first_s = min(added[k].first_s, tracks[j].first_s)
                break
    for k in range(new.shape[0]):
        added[k].hits += 1
        added[k].confidence = 1.0 - (1.0 - added[k].confidence) * (1.0 - confidence[new[k]] / 2)

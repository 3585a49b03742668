"""Where each disc is now, how a new sighting corrects it, and whether it has proven to move.

A constant-velocity Kalman filter runs for every whole object. Its velocity alone proves nothing: attitude errors, a changing
point of view and depth noise all make a tree seem to move. A velocity is reported only after a displacement larger than
everything of that kind together: three standard deviations of the filter, the attitude error times the distance, the depth
noise, the change of the radius (one hidden edge shifts the centre) and the shape's part when it is seen from another side.
"""

from __future__ import annotations

import math

import numba

from perception.kernel_cache import njit
from perception.tracking.tracks import RULES_TYPE, TRACKS_TYPE

_SPEED_FIRST_M_S = 4.0
"""Standard deviation of the velocity of something seen once."""
_COAST_S = 0.3
"""A disc that has not proven to move is taken to be at rest when it was not seen for this long."""
_GAP_S = 0.15
"""A proof of movement starts anew after a gap this long: what is seen again may be something else."""
_POSITION_SIGMA_MIN_M = 0.02
_SHAPE_SIGMA = 0.1
"""Standard deviation of the centre in radii: hardly anything is round."""
_SHAPE_SHIFT = 0.5
"""Shift of the centre in radii for a change of the line of sight by one radian."""
_ANCHOR_S = 0.5
_MOVED_SIGMAS = 3.0
_MOVED_FRAMES = 3
_STEADY = 0.3
"""The last part of the way must be covered at this fraction of the mean speed at least: a jump is no movement."""
_OFF_FRACTION = 0.5
"""The filter's velocity may differ from the mean one by this fraction of it, and by the least speed that counts."""
_RADIUS_FRAMES = 5

_F8 = numba.types.float64
_I8 = numba.types.int64
_PREDICT = numba.void(TRACKS_TYPE, _F8, RULES_TYPE)
_START = numba.void(TRACKS_TYPE, _F8, _F8[:, ::1], _F8[::1], _I8[::1], _F8, _F8, RULES_TYPE)
_CORRECT = numba.void(TRACKS_TYPE, _F8, _F8[:, ::1], _F8[::1], _F8[::1], _I8[::1], numba.boolean[::1], _F8, _F8, RULES_TYPE)


@njit(_PREDICT, cache=True, nogil=True, error_model="numpy")
def predict(tracks, t_s, rules):  # type: ignore[no-untyped-def]
    """Fill the tracks' now_ fields for `t_s`."""
    rule = rules[0]
    for j in range(tracks.shape[0]):
        track = tracks[j]
        dt = max(t_s - track.updated_s, 0.0)
        before, now = track.covariance, track.now_covariance
        is_at_rest = track.is_moving == 0 and dt > _COAST_S
        track.now_v_north_m_s = 0.0 if is_at_rest else track.v_north_m_s
        track.now_v_east_m_s = 0.0 if is_at_rest else track.v_east_m_s
        growth_m_s = rule.memory_growth_m_s if track.is_moving == 0 else rule.memory_growth_moving_m_s
        track.now_radius_m = track.radius_m + growth_m_s * max(t_s - track.seen_s, 0.0)
        track.now_north_m = track.north_m + track.now_v_north_m_s * dt
        track.now_east_m = track.east_m + track.now_v_east_m_s * dt
        for a in range(2):
            for b in range(2):
                if is_at_rest:
                    spread = rule.memory_growth_m_s * dt
                    now[a, b] = before[a, b] + (spread * spread if a == b else 0.0)
                    now[a, b + 2] = now[a + 2, b] = 0.0
                    now[a + 2, b + 2] = _SPEED_FIRST_M_S**2 if a == b else 0.0
                    continue
                noise = rule.manoeuvre_m_s2**2 * dt if a == b else 0.0
                cross = before[a, b + 2] + dt * before[a + 2, b + 2] + noise * dt / 2
                now[a, b] = before[a, b] + dt * (before[a, b + 2] + before[a + 2, b] + dt * before[a + 2, b + 2])
                now[a, b] += noise * dt * dt / 3
                now[a, b + 2] = cross
                now[b + 2, a] = cross
                now[a + 2, b + 2] = before[a + 2, b + 2] + noise


@njit("UniTuple(f8,3)(f8,f8,f8,f8,f8)", cache=True, nogil=True, error_model="numpy")
def _measured(sight_north, sight_east, radius, sigma, bearing_error):  # type: ignore[no-untyped-def]
    """Covariance (nn, ne, ee) of a sighted centre."""
    distance = max(math.hypot(sight_north, sight_east), 1e-6)
    cos, sin = sight_north / distance, sight_east / distance
    least = _POSITION_SIGMA_MIN_M**2 + (_SHAPE_SIGMA * radius) ** 2
    along = sigma * sigma + least
    across = (bearing_error * distance) ** 2 + least
    nn = along * cos * cos + across * sin * sin
    ee = along * sin * sin + across * cos * cos
    return nn, (along - across) * cos * sin, ee


@njit(numba.void(TRACKS_TYPE, _I8, _I8, _F8, _F8, _F8), cache=True, nogil=True, error_model="numpy")
def _drop_anchor(tracks, j, k, t_s, camera_north, camera_east):  # type: ignore[no-untyped-def]
    """Make the present state anchor `k` of track `j`."""
    track = tracks[j]
    track.anchor_s[k] = t_s
    track.anchor_north_m[k] = track.north_m
    track.anchor_east_m[k] = track.east_m
    track.anchor_radius_m[k] = track.radius_m
    track.anchor_sight_north_m[k] = track.north_m - camera_north
    track.anchor_sight_east_m[k] = track.east_m - camera_east
    track.anchor_variance_nn[k] = track.covariance[0, 0]
    track.anchor_variance_ne[k] = track.covariance[0, 1]
    track.anchor_variance_ee[k] = track.covariance[1, 1]


@njit(_START, cache=True, nogil=True, error_model="numpy")
def start(tracks, t_s, discs, sigma_m, new, camera_north, camera_east, rules):  # type: ignore[no-untyped-def]
    """Fill the filter's part of `tracks` with the sighted discs number `new`, one each."""
    bearing_error = math.radians(rules[0].bearing_error_deg)
    for j in range(new.shape[0]):
        track, i = tracks[j], new[j]
        track.north_m = track.now_north_m = discs[i, 0]
        track.east_m = track.now_east_m = discs[i, 1]
        track.radius_m = discs[i, 2]
        track.v_north_m_s = track.v_east_m_s = 0.0
        track.now_v_north_m_s = track.now_v_east_m_s = 0.0
        sight_north, sight_east = discs[i, 0] - camera_north, discs[i, 1] - camera_east
        nn, ne, ee = _measured(sight_north, sight_east, discs[i, 2], sigma_m[i], bearing_error)
        track.covariance[:, :] = 0.0
        track.covariance[0, 0], track.covariance[0, 1], track.covariance[1, 0], track.covariance[1, 1] = nn, ne, ne, ee
        track.covariance[2, 2] = track.covariance[3, 3] = _SPEED_FIRST_M_S**2
        track.now_covariance[:, :] = track.covariance
        track.updated_s = t_s
        track.is_moving = track.moved_frames = 0
        _drop_anchor(tracks, j, 0, t_s, camera_north, camera_east)
        _drop_anchor(tracks, j, 1, t_s, camera_north, camera_east)


@njit("f8(f8,f8,f8,f8,f8,f8)", cache=True, nogil=True, error_model="numpy")
def _misplaced(sight_north, sight_east, way_north, way_east, depth_noise_1_m, bearing_error):  # type: ignore[no-untyped-def]
    """How far a disc may be misplaced along the unit vector `way` by errors that do not average out, in m."""
    distance = max(math.hypot(sight_north, sight_east), 1e-6)
    along = (sight_north * way_north + sight_east * way_east) / distance
    across = (sight_north * way_east - sight_east * way_north) / distance
    return math.hypot(along * depth_noise_1_m * distance * distance, across * bearing_error * distance)


@njit(numba.void(TRACKS_TYPE, _I8, _F8, _F8, _F8, RULES_TYPE), cache=True, nogil=True, error_model="numpy")
def _judge_movement(tracks, j, t_s, camera_north, camera_east, rules):  # type: ignore[no-untyped-def]
    """Set whether track `j` has proven to move since its older anchor."""
    rule, track = rules[0], tracks[j]
    elapsed_s = t_s - track.anchor_s[0]
    north, east = track.north_m - track.anchor_north_m[0], track.east_m - track.anchor_east_m[0]
    way_m = math.hypot(north, east)
    if elapsed_s >= rule.moving_after_s and way_m > 0.0:
        north, east = north / way_m, east / way_m
        before_north, before_east = track.anchor_sight_north_m[0], track.anchor_sight_east_m[0]
        sight_north, sight_east = track.north_m - camera_north, track.east_m - camera_east
        variance = north * north * (track.covariance[0, 0] + track.anchor_variance_nn[0])
        variance += 2.0 * north * east * (track.covariance[0, 1] + track.anchor_variance_ne[0])
        variance += east * east * (track.covariance[1, 1] + track.anchor_variance_ee[0])
        turn = abs(
            math.atan2(
                before_north * sight_east - before_east * sight_north, before_north * sight_north + before_east * sight_east
            )
        )
        needed_m = _MOVED_SIGMAS * math.sqrt(max(variance, 0.0)) + _SHAPE_SHIFT * track.radius_m * turn
        needed_m += abs(track.radius_m - track.anchor_radius_m[0])
        needed_m += _misplaced(before_north, before_east, north, east, rule.depth_noise_1_m, math.radians(rule.bearing_error_deg))
        needed_m += _misplaced(sight_north, sight_east, north, east, rule.depth_noise_1_m, math.radians(rule.bearing_error_deg))
        speed_m_s = way_m / elapsed_s
        lately_m = (track.north_m - track.anchor_north_m[1]) * north + (track.east_m - track.anchor_east_m[1]) * east
        is_steady = lately_m >= _STEADY * speed_m_s * (t_s - track.anchor_s[1])
        off_m_s = math.hypot(track.v_north_m_s - speed_m_s * north, track.v_east_m_s - speed_m_s * east)
        is_steady &= off_m_s <= _OFF_FRACTION * speed_m_s + rule.moving_speed_min_m_s
        if way_m > needed_m and speed_m_s > rule.moving_speed_min_m_s and is_steady:
            track.moved_frames += 1
            if track.moved_frames >= _MOVED_FRAMES:
                track.is_moving = 1
        else:
            track.moved_frames = 0
            if elapsed_s >= _ANCHOR_S and way_m < needed_m / 2:
                track.is_moving = 0
    if t_s - track.anchor_s[1] >= _ANCHOR_S:
        track.anchor_s[0] = track.anchor_s[1]
        track.anchor_north_m[0], track.anchor_east_m[0] = track.anchor_north_m[1], track.anchor_east_m[1]
        track.anchor_radius_m[0] = track.anchor_radius_m[1]
        track.anchor_sight_north_m[0] = track.anchor_sight_north_m[1]
        track.anchor_sight_east_m[0] = track.anchor_sight_east_m[1]
        track.anchor_variance_nn[0] = track.anchor_variance_nn[1]
        track.anchor_variance_ne[0] = track.anchor_variance_ne[1]
        track.anchor_variance_ee[0] = track.anchor_variance_ee[1]
        _drop_anchor(tracks, j, 1, t_s, camera_north, camera_east)


@njit(_CORRECT, cache=True, nogil=True, error_model="numpy")
def correct(  # type: ignore[no-untyped-def]
    tracks, t_s, discs, sigma_m, confidence, track_of, is_isolated, camera_north, camera_east, rules
):
    """Correct the predicted tracks by the sighted discs that belong to them.

    track_of: (m,) index of each sighted disc's track, -1 for none. is_isolated: (m,) nothing else was sighted close by.
    """
    rule = rules[0]
    for i in range(discs.shape[0]):
        j = track_of[i]
        if j < 0:
            continue
        track = tracks[j]
        sight_north, sight_east = discs[i, 0] - camera_north, discs[i, 1] - camera_east
        nn, ne, ee = _measured(sight_north, sight_east, discs[i, 2], sigma_m[i], math.radians(rule.bearing_error_deg))
        now, after = track.now_covariance, track.covariance
        s_nn, s_ne, s_ee = now[0, 0] + nn, now[0, 1] + ne, now[1, 1] + ee
        determinant = s_nn * s_ee - s_ne * s_ne
        miss_north, miss_east = discs[i, 0] - track.now_north_m, discs[i, 1] - track.now_east_m
        for a in range(4):
            north = (now[a, 0] * s_ee - now[a, 1] * s_ne) / determinant
            east = (now[a, 1] * s_nn - now[a, 0] * s_ne) / determinant
            step = north * miss_north + east * miss_east
            if a == 0:
                track.north_m = track.now_north_m + step
            elif a == 1:
                track.east_m = track.now_east_m + step
            elif a == 2:
                track.v_north_m_s = track.now_v_north_m_s + step
            else:
                track.v_east_m_s = track.now_v_east_m_s + step
            for b in range(4):
                after[a, b] = now[a, b] - north * now[0, b] - east * now[1, b]
        for a in range(4):
            for b in range(a):
                after[a, b] = after[b, a] = (after[a, b] + after[b, a]) / 2
        was_lost = track.is_moving == 0 and t_s - track.updated_s > _GAP_S
        track.hits += 1
        track.radius_m += (discs[i, 2] - track.radius_m) / min(track.hits, _RADIUS_FRAMES)
        track.confidence = 1.0 - (1.0 - track.confidence) * (1.0 - confidence[i] / 2)
        track.updated_s = track.seen_s = t_s
        track.seen_through = 0
        if was_lost:
            _drop_anchor(tracks, j, 0, t_s, camera_north, camera_east)
            _drop_anchor(tracks, j, 1, t_s, camera_north, camera_east)
        if is_isolated[i]:
            _judge_movement(tracks, j, t_s, camera_north, camera_east, rules)

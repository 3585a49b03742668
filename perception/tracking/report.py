"""From tracks to the discs that are reported."""

from __future__ import annotations

import numba

from perception.kernel_cache import njit
from perception.tracking.tracks import RULES_TYPE, TRACKS_TYPE

_F8 = numba.types.float64
_REPORT = numba.int64(TRACKS_TYPE, _F8, _F8, _F8, RULES_TYPE, _F8[:, ::1], _F8[::1], _F8[::1])


@njit(_REPORT, cache=True, nogil=True, error_model="numpy")
def report(tracks, t_s, memory_s, memory_moving_s, rules, discs, age_s, confidence):  # type: ignore[no-untyped-def]
    """Fill discs (n, 5), age_s (n,) and confidence (n,) with what is neither withheld nor too old; returns how many."""
    rule, shown = rules[0], 0
    for j in range(tracks.shape[0]):
        track = tracks[j]
        age = max(t_s - track.seen_s, 0.0)  # times that were shifted with a clock set back are rounded
        if track.is_withheld == 1 or age > memory_s:
            continue
        # It was corrected, if it was seen, after it was predicted.
        is_seen_now = track.updated_s == t_s
        growth_m_s, fades_s = rule.memory_growth_m_s, memory_s
        discs[shown, 0], discs[shown, 1] = track.north_m, track.east_m
        discs[shown, 3] = discs[shown, 4] = 0.0
        if track.is_moving == 1:
            growth_m_s, fades_s = rule.memory_growth_moving_m_s, memory_moving_s
            discs[shown, 3], discs[shown, 4] = track.v_north_m_s, track.v_east_m_s
            if not is_seen_now:
                discs[shown, 0], discs[shown, 1] = track.now_north_m, track.now_east_m
        discs[shown, 2] = track.radius_m + growth_m_s * age
        age_s[shown] = age
        confidence[shown] = track.confidence * min(max(1.0 - age / max(fades_s, 1e-9), 0.0), 1.0)
        shown += 1
    return shown

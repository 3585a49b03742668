"""Short-term memory of static discs: what has left the field of view or the range is still there, for a while.

Rows are (north_m, east_m, radius_m, seen_s, clear_s, sightings): when the disc was last seen, since when its place was in open
view showing it (inf: it was not), and how many sightings its mean position is of (at most `SIGHTINGS_MAX`).
"""

from __future__ import annotations

import math

import numpy as np
from numba import void

from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.ac2f.recollection import BUCKETS, DISCS, RECOLLECTION_TYPE
from flightapp.planning.ac2f.records import MEMORY_TYPE, NUMBER, PARAMETERS_TYPE, ROWS, TRUTH, VIEW_TYPE, WHOLE, Record
from flightapp.planning.ac2f.scene import fill, is_near_any

SIGHTINGS_MAX = 10.0
CLEAR_S = 0.3  # looked through for this long: gone
EDGE_RAD = 0.1  # of a sector that was not observed; the vehicle turns while the picture ages
CELL_M = 2.0  # of the hash grid: at least twice the gate


@compiled("i8(f8,f8)")
def _bucket(cell_n: float, cell_e: float) -> int:
    return (int(cell_n) * 73856093 ^ int(cell_e) * 19349663) & (BUCKETS - 1)


@compiled(TRUTH(ROWS, NUMBER, NUMBER, NUMBER))
def _in_view(unseen: Array, bearing: float, half: float, distance: float) -> bool:
    """Whether all of the disc at `bearing`, of half angle `half` (rad), is outside the sectors `unseen`."""
    reach = half + EDGE_RAD
    for k in range(unseen.shape[0]):
        width = (unseen[k, 1] - unseen[k, 0]) % (2.0 * math.pi)
        into = (bearing - unseen[k, 0] + reach) % (2.0 * math.pi)
        if into < width + 2.0 * reach:
            return False
    return distance > 0.0


@compiled(TRUTH(ROWS, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER))
def _hidden(discs: Array, own_n: float, own_e: float, n: float, e: float, radius: float) -> bool:
    """Whether any of `discs` covers a part of the disc (n, e, radius) as seen from the own position."""
    distance = math.hypot(n - own_n, e - own_e)
    unit_n = (n - own_n) / distance
    unit_e = (e - own_e) / distance
    for i in range(discs.shape[0]):
        dn = discs[i, 0] - own_n
        de = discs[i, 1] - own_e
        along = dn * unit_n + de * unit_e
        if 0.0 < along < distance and abs(de * unit_n - dn * unit_e) < discs[i, 2] + radius:
            return True
    return False


@compiled(void(ROWS, MEMORY_TYPE, NUMBER))
def _expire(rows: Array, memory: Record, oldest_s: float) -> None:
    m = memory[0]
    kept = 0
    for i in range(m.disc_count):
        if rows[i, 3] >= oldest_s:
            if kept != i:
                for c in range(rows.shape[1]):  # a row at once would take seconds to compile, for its check of the shapes
                    rows[kept, c] = rows[i, c]
            kept += 1
    m.disc_count = kept


@compiled(void(PARAMETERS_TYPE, MEMORY_TYPE, ROWS, NUMBER, ROWS, RECOLLECTION_TYPE))
def _take(parameters: Record, memory: Record, discs: Array, discs_t_s: float, trail: Array, recollection: Record) -> None:
    """Match each static disc with the nearest remembered one that is not matched yet, or add it."""
    p = parameters[0]
    m = memory[0]
    gate_m = min(p.disc_memory_gate_m, 0.5 * CELL_M)
    rows = recollection[0].discs[:]
    heads = recollection[0].heads[:]
    links = recollection[0].links[:]
    heads[:] = -1
    for i in range(m.disc_count):
        bucket = _bucket(math.floor(rows[i, 0] / CELL_M), math.floor(rows[i, 1] / CELL_M))
        links[i] = heads[bucket]
        heads[bucket] = i
    speed_max2 = p.disc_memory_speed_max_m_s**2
    known = m.disc_count
    for d in range(discs.shape[0]):
        if discs[d, 3] * discs[d, 3] + discs[d, 4] * discs[d, 4] > speed_max2:
            continue
        n = discs[d, 0]
        e = discs[d, 1]
        nearest = -1
        nearest2 = gate_m * gate_m
        from_e = math.floor((e - gate_m) / CELL_M)
        to_e = math.floor((e + gate_m) / CELL_M)
        cell_n = math.floor((n - gate_m) / CELL_M)
        to_n = math.floor((n + gate_m) / CELL_M)
        while cell_n <= to_n:
            cell_e = from_e
            while cell_e <= to_e:
                i = heads[_bucket(cell_n, cell_e)]
                while i >= 0:
                    apart2 = (rows[i, 0] - n) ** 2 + (rows[i, 1] - e) ** 2
                    if apart2 <= nearest2 and rows[i, 3] < discs_t_s and (apart2 < nearest2 or i < nearest or nearest < 0):
                        nearest = i
                        nearest2 = apart2
                    i = links[i]
                cell_e += 1.0
            cell_n += 1.0
        if nearest >= 0:
            row = rows[nearest]
            row[5] = min(row[5] + 1.0, SIGHTINGS_MAX)
            row[0] += (n - row[0]) / row[5]
            row[1] += (e - row[1]) / row[5]
            row[2] += (discs[d, 2] - row[2]) / row[5]
            row[3] = discs_t_s
            row[4] = np.inf
            continue
        small = discs[d, 2] <= p.vehicle_radius_max_m
        if small and is_near_any(trail, n, e, discs[d, 2] + p.vehicle_disc_m):
            continue
        if m.disc_count < DISCS:
            row = rows[m.disc_count]
            m.disc_count += 1
        else:
            oldest = 0
            for i in range(1, known):
                if rows[i, 3] < rows[oldest, 3]:
                    oldest = i
            if rows[oldest, 3] >= discs_t_s:
                return
            row = rows[oldest]
        row[0] = n
        row[1] = e
        row[2] = discs[d, 2]
        row[3] = discs_t_s
        row[4] = np.inf
        row[5] = 1.0


@compiled(void(PARAMETERS_TYPE, MEMORY_TYPE, VIEW_TYPE, ROWS, NUMBER, ROWS, ROWS))
def _look_through(
    parameters: Record, memory: Record, view: Record, discs: Array, discs_t_s: float, unseen: Array, rows: Array
) -> None:
    """Forget what is near and in open view, and was not seen for a while."""
    p = parameters[0]
    m = memory[0]
    own_n = view[0].own_n
    own_e = view[0].own_e
    kept = 0
    for i in range(m.disc_count):
        gone = False
        if rows[i, 3] < discs_t_s:
            dn = rows[i, 0] - own_n
            de = rows[i, 1] - own_e
            distance = math.hypot(dn, de)
            radius = rows[i, 2]
            clear = radius < distance < p.disc_memory_sight_m + radius
            if clear and unseen.shape[0] > 0:
                clear = _in_view(unseen, math.atan2(de, dn), math.asin(min(1.0, radius / distance)), distance)
            if clear and not _hidden(discs, own_n, own_e, rows[i, 0], rows[i, 1], radius):
                rows[i, 4] = min(rows[i, 4], discs_t_s)
                gone = discs_t_s - rows[i, 4] >= CLEAR_S
            else:
                rows[i, 4] = np.inf
        if not gone:
            if kept != i:
                for c in range(rows.shape[1]):  # a row at once would take seconds to compile, for its check of the shapes
                    rows[kept, c] = rows[i, c]
            kept += 1
    m.disc_count = kept


@compiled(void(PARAMETERS_TYPE, MEMORY_TYPE, VIEW_TYPE, ROWS, NUMBER, ROWS, ROWS, RECOLLECTION_TYPE))
def remember_discs(
    parameters: Record,
    memory: Record,
    view: Record,
    discs: Array,
    discs_t_s: float,
    unseen: Array,
    trail: Array,
    recollection: Record,
) -> None:
    """Bring the memory up to date with the observation `discs` (n, >=5) of `discs_t_s`.

    unseen: (u, 2) bearings not observed. trail: (k, >=2) where other vehicles are or were: no disc there is remembered. The same
    observation again changes nothing but what has expired.
    """
    m = memory[0]
    if parameters[0].disc_memory_s <= 0.0:
        return
    rows = recollection[0].discs[:]
    _expire(rows, memory, view[0].t_s - parameters[0].disc_memory_s)
    if m.disc_count > 0 and discs_t_s <= m.discs_t_s:
        return
    m.discs_t_s = discs_t_s
    _take(parameters, memory, discs, discs_t_s, trail, recollection)
    _look_through(parameters, memory, view, discs, discs_t_s, unseen, rows)


@compiled(WHOLE(PARAMETERS_TYPE, MEMORY_TYPE, VIEW_TYPE, ROWS, RECOLLECTION_TYPE, ROWS, WHOLE))
def recall_discs(
    parameters: Record, memory: Record, view: Record, trail: Array, recollection: Record, scene: Array, count: int
) -> int:
    """Add what is remembered and was not observed now to `scene` (cap, 6), from row `count`; the new number of rows."""
    p = parameters[0]
    m = memory[0]
    v = view[0]
    rows = recollection[0].discs[:]
    for i in range(m.disc_count):
        if rows[i, 3] >= m.discs_t_s or count >= scene.shape[0]:
            continue
        north, east, radius = rows[i, 0], rows[i, 1], rows[i, 2]
        distance = math.hypot(north - v.own_n, east - v.own_e)
        if distance - radius > p.obstacle_range_m:
            continue
        if radius <= p.vehicle_radius_max_m and is_near_any(trail, north, east, radius + p.vehicle_disc_m):
            continue
        fill(scene[count], north, east, 0.0, 0.0, radius + p.inflation_m, distance)
        count += 1
    return count

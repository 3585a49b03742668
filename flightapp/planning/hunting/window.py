"""The widened dynamic window: expected velocities at the end of the horizon, of which the first control period is flown.

A sample is reached along ramps of speed and turn rate, within the acceleration limits (CPPPEA 2.5, corrected: the source predicts
with the expected velocity as if it were there at once, and collides). A sample counts only if, after its first control period,
the vehicle can brake to a stop without touching anything.
"""

from __future__ import annotations

import math

import numba
import numpy as np
from numba import void
from numpy.typing import NDArray

from flightapp.core.clearance import way_gap_m
from flightapp.core.compiled import compiled
from flightapp.core.types import Array
from flightapp.planning.critics import best_candidate, clearance_score, heading_score
from flightapp.planning.critics.avoidance import avoidance_score
from flightapp.planning.critics.wanted_speed import wanted_speed_score

Record = NDArray[np.void]

MOTION = np.dtype(
    [
        ("speed_max", "f8"),  # m/s
        ("acceleration", "f8"),  # m/s2
        ("braking", "f8"),
        ("sideways", "f8"),  # acceleration across the course
        ("turn_max", "f8"),  # rad/s
        ("turn_acceleration", "f8"),
        ("period_s", "f8"),  # of control
        ("reaction_s", "f8"),  # until braking begins
        ("horizon_s", "f8"),
        ("window_s", "f8"),  # in which a sample must be reachable
        ("heading_weight", "f8"),
        ("clearance_weight", "f8"),
        ("velocity_weight", "f8"),
        ("beyond", "f8"),  # 1: the free way counts beyond the horizon, too
    ],
    align=True,
)
STATE = np.dtype(
    [
        ("n", "f8"),
        ("e", "f8"),
        ("course", "f8"),  # rad
        ("speed", "f8"),
        ("turn", "f8"),  # rad/s
        ("aim_n", "f8"),
        ("aim_e", "f8"),
        ("wanted_speed", "f8"),
        ("avoid_weight", "f8"),
        ("avoid_course", "f8"),
        ("best", "i8"),  # chosen: index of the sample, -1 for none
        ("first_speed", "f8"),  # and what is flown of it
        ("first_turn", "f8"),
        ("free_m", "f8"),
        ("collisions", "i8"),  # samples without room to brake
    ],
    align=True,
)
MOTION_TYPE = numba.types.Array(numba.from_dtype(MOTION), 1, "C")
STATE_TYPE = numba.types.Array(numba.from_dtype(STATE), 1, "C")
ROWS = numba.float64[:, ::1]
VECTOR = numba.float64[::1]
NUMBER = numba.float64
BRAKING_STEPS = 6
ADMISSIBLE, BLOCKED = 0, 1
PAIR_TYPE = numba.types.UniTuple(NUMBER, 2)  # type: ignore[no-untyped-call]


@compiled(NUMBER(NUMBER, NUMBER, NUMBER))
def _towards(value: float, wanted: float, reach: float) -> float:
    moved: float = min(value + reach, max(value - reach, wanted))
    return moved


@compiled(NUMBER(MOTION_TYPE, NUMBER, NUMBER))
def _turn_limited(motion: Record, turn: float, speed: float) -> float:
    """`turn` within the limits of rate and of acceleration across the course."""
    m = motion[0]
    most = min(m.turn_max, m.sideways / max(speed, 1e-6))
    limited: float = min(most, max(-most, turn))
    return limited


@compiled(void(MOTION_TYPE, STATE_TYPE, numba.int64, numba.int64, VECTOR, VECTOR))
def sample_window(motion: Record, state: Record, speed_samples: int, turn_samples: int, speeds: Array, turns: Array) -> None:
    """Fill speeds, turns ((speed_samples + 2) * (turn_samples + 3),): a grid over the window, the present values, 0, and the
    turn rate that points at the aim."""
    m, s = motion[0], state[0]
    low, high = max(0.0, s.speed - m.acceleration * m.window_s), min(m.speed_max, s.speed + m.acceleration * m.window_s)
    high = max(low, high)
    turn_low = max(-m.turn_max, s.turn - m.turn_acceleration * m.window_s)
    turn_high = max(turn_low, min(m.turn_max, s.turn + m.turn_acceleration * m.window_s))
    error = math.atan2(s.aim_e - s.e, s.aim_n - s.n) - s.course
    error -= 2.0 * math.pi * math.floor((error + math.pi) / (2.0 * math.pi))
    pointing = math.copysign(min(abs(error) / m.period_s, math.sqrt(m.turn_acceleration * abs(error))), error)
    width = turn_samples + 3
    for i in range(speed_samples + 2):
        if i < speed_samples:
            speed = low + (high - low) * i / (speed_samples - 1)
        else:
            speed = min(high, max(low, s.speed if i == speed_samples else 0.0))
        for j in range(width):
            if j < turn_samples:
                turn = turn_low + (turn_high - turn_low) * j / (turn_samples - 1)
            else:
                turn = s.turn if j == turn_samples else 0.0 if j == turn_samples + 1 else pointing
                turn = min(turn_high, max(turn_low, turn))
            speeds[i * width + j] = speed
            turns[i * width + j] = turn


@compiled(numba.int64(ROWS, NUMBER, NUMBER, NUMBER, NUMBER, ROWS))
def near_discs(scene: Array, n: float, e: float, reach_m: float, horizon_s: float, out: Array) -> int:
    """Copy the rows of `scene` (m, >=5) that come within `reach_m` in `horizon_s` into `out` (>= m, 5); how many."""
    count = 0
    for i in range(scene.shape[0]):
        drift = math.hypot(scene[i, 3], scene[i, 4]) * horizon_s
        if math.hypot(scene[i, 0] - n, scene[i, 1] - e) <= reach_m + scene[i, 2] + drift:
            for k in range(5):
                out[count, k] = scene[i, k]
            count += 1
    return count


@compiled(numba.boolean(ROWS, numba.int64, *(NUMBER,) * 7))
def _touches(
    discs: Array, count: int, n: float, e: float, to_n: float, to_e: float, bulge: float, from_s: float, until_s: float
) -> bool:
    """Whether the way (n, e) -> (to_n, to_e), which is `bulge` m off its chord, meets one of `discs`, which move."""
    for i in range(count):
        start_n = n - discs[i, 0] - discs[i, 3] * from_s
        start_e = e - discs[i, 1] - discs[i, 4] * from_s
        along_n = to_n - n - discs[i, 3] * (until_s - from_s)
        along_e = to_e - e - discs[i, 4] * (until_s - from_s)
        reach = discs[i, 2] + bulge
        far = reach + abs(along_n) + abs(along_e)
        if abs(start_n) > far or abs(start_e) > far:
            continue
        if start_n * start_n + start_e * start_e <= reach * reach and start_n * along_n + start_e * along_e >= 0.0:
            continue  # within the bulge's allowance already, and leaving
        if way_gap_m(start_n, start_e, along_n, along_e, reach) <= 0.0:
            return True
    return False


@compiled(numba.boolean(MOTION_TYPE, STATE_TYPE, ROWS, numba.int64, NUMBER, NUMBER))
def can_brake(motion: Record, state: Record, discs: Array, count: int, speed: float, turn: float) -> bool:
    """Whether `speed` and `turn` can be flown for a control period and the reaction, then braked to a stop, without contact."""
    m, s = motion[0], state[0]
    n, e, course = s.n, s.e, s.course
    t_s = 0.0
    held_s = max(m.period_s, m.reaction_s)
    held_steps = max(1, math.ceil(held_s * abs(turn) / 0.5))
    braking_s = speed / m.braking
    for k in range(held_steps + BRAKING_STEPS):
        if k < held_steps:
            step_s = held_s / held_steps
            v, w = speed, turn
        else:
            step_s = braking_s / BRAKING_STEPS
            v = speed * (1.0 - (k - held_steps + 0.5) / BRAKING_STEPS)
            w = _towards(turn, 0.0, m.turn_acceleration * (t_s - held_s + step_s))
        way, bend = v * step_s, w * step_s
        if way <= 0.0:
            break
        to_n = n + way * math.cos(course + 0.5 * bend)
        to_e = e + way * math.sin(course + 0.5 * bend)
        if _touches(discs, count, n, e, to_n, to_e, 0.125 * way * abs(bend), t_s, t_s + step_s):
            return False
        n, e, course, t_s = to_n, to_e, course + bend, t_s + step_s
    return True


@compiled(NUMBER(ROWS, *(NUMBER,) * 5))
def ray_free_m(scene: Array, n: float, e: float, along_n: float, along_e: float, length_m: float) -> float:
    """Way along a ray to the first standing disc of `scene`, at most `length_m`."""
    free = length_m
    for i in range(scene.shape[0]):
        if scene[i, 3] != 0.0 or scene[i, 4] != 0.0:
            continue
        dn, de = scene[i, 0] - n, scene[i, 1] - e
        ahead = dn * along_n + de * along_e
        rest = scene[i, 2] * scene[i, 2] - (dn * dn + de * de - ahead * ahead)
        if ahead <= 0.0 or rest < 0.0:
            continue
        free = min(free, max(0.0, ahead - math.sqrt(rest)))
    return free


@compiled(void(MOTION_TYPE, STATE_TYPE, ROWS, numba.int64, numba.int64, VECTOR, VECTOR, ROWS))
def _judge(motion: Record, state: Record, discs: Array, count: int, steps: int, speeds: Array, turns: Array, ends: Array) -> None:
    """Fill ends (7, n): north and east where each sample ends, cosine and sine of the course there, free way in m up to the
    first contact, and speed and turn rate of the first control period."""
    m, s = motion[0], state[0]
    free_max = m.speed_max * m.horizon_s
    for c in range(speeds.shape[0]):
        n, e, course, t_s, way_m, free_m = s.n, s.e, s.course, 0.0, 0.0, free_max
        touched = False
        for k in range(steps):
            step_s = m.period_s if k == 0 else (m.horizon_s - m.period_s) / (steps - 1)
            reached_s = t_s + step_s
            v = _towards(s.speed, speeds[c], m.acceleration * reached_s)
            w = _turn_limited(motion, _towards(s.turn, turns[c], m.turn_acceleration * reached_s), v)
            w = _towards(s.turn, w, m.turn_acceleration * reached_s)
            if k == 0:
                ends[5, c], ends[6, c] = v, w
            way, bend = v * step_s, w * step_s
            to_n = n + way * math.cos(course + 0.5 * bend)
            to_e = e + way * math.sin(course + 0.5 * bend)
            bulge = 0.125 * way * abs(bend)
            if not touched and _touches(discs, count, n, e, to_n, to_e, bulge, t_s, reached_s):
                touched, free_m = True, way_m
            way_m += way
            n, e, course, t_s = to_n, to_e, course + bend, reached_s
        ends[0, c], ends[1, c] = n, e
        ends[2, c], ends[3, c] = math.cos(course), math.sin(course)
        if not touched and m.beyond > 0.0:
            free_m = way_m + ray_free_m(discs[:count], n, e, math.cos(course), math.sin(course), free_max - way_m)
        ends[4, c] = free_m


@compiled(void(MOTION_TYPE, STATE_TYPE, ROWS, numba.int64, ROWS, numba.int64[::1]))
def _admit(motion: Record, state: Record, discs: Array, count: int, ends: Array, verdicts: NDArray[np.int64]) -> None:
    """BLOCKED for samples whose first control period leaves no room to brake; those with the same one are judged once."""
    tried = np.empty((ends.shape[1], 3))
    known = 0
    for c in range(ends.shape[1]):
        verdict = -1
        for k in range(known):
            if tried[k, 0] == ends[5, c] and tried[k, 1] == ends[6, c]:
                verdict = int(tried[k, 2])
                break
        if verdict < 0:
            verdict = ADMISSIBLE if can_brake(motion, state, discs, count, ends[5, c], ends[6, c]) else BLOCKED
            tried[known, 0], tried[known, 1], tried[known, 2] = ends[5, c], ends[6, c], verdict
            known += 1
        verdicts[c] = verdict


@compiled(
    void(
        MOTION_TYPE,
        STATE_TYPE,
        ROWS,
        numba.int64,
        numba.int64,
        numba.int64,
        ROWS,
        VECTOR,
        VECTOR,
        ROWS,
        ROWS,
        VECTOR,
        numba.int64[::1],
    )
)
def choose(
    motion: Record,
    state: Record,
    scene: Array,
    steps: int,
    speed_samples: int,
    turn_samples: int,
    discs: Array,
    speeds: Array,
    turns: Array,
    ends: Array,
    scores: Array,
    totals: Array,
    verdicts: NDArray[np.int64],
) -> None:
    """Fill the choice in `state` for the scene (m, >=5) of inflated discs.

    Room for n samples: discs (>= m, 5), speeds, turns, totals, verdicts (n,), ends (7, n), scores (4, n). `best` -1: no sample
    leaves room to brake; `first_speed` and `first_turn` then are those of braking on along the present arc.
    """
    m, s = motion[0], state[0]
    longest_s = m.horizon_s + m.reaction_s + m.speed_max / m.braking
    reach_m = m.speed_max * longest_s
    count = near_discs(scene, s.n, s.e, reach_m, longest_s, discs)
    sample_window(motion, state, speed_samples, turn_samples, speeds, turns)
    _judge(motion, state, discs, count, steps, speeds, turns, ends)
    _admit(motion, state, discs, count, ends, verdicts)
    s.collisions = 0
    for c in range(verdicts.shape[0]):
        s.collisions += verdicts[c]
    free_max = m.speed_max * m.horizon_s
    braking = s.speed * m.period_s + s.speed * s.speed / (2.0 * m.braking)
    for c in range(verdicts.shape[0]):
        totals[c] = max(0.0, ends[4, c] - braking)
    heading_score(ends[0], ends[1], ends[2], ends[3], s.aim_n, s.aim_e, scores[0])
    clearance_score(totals, max(1e-6, free_max - braking), scores[1])
    wanted_speed_score(speeds, s.wanted_speed, scores[2])
    avoidance_score(ends[2], ends[3], s.avoid_course, scores[3])
    weights = np.empty(4)
    weights[0] = m.heading_weight / math.pi
    weights[1] = m.clearance_weight / max(1e-6, free_max - braking)
    weights[2] = m.velocity_weight / m.speed_max
    weights[3] = s.avoid_weight / math.pi
    best = best_candidate(scores, weights, verdicts, True, totals)
    s.best = best
    if best >= 0:
        s.first_speed, s.first_turn, s.free_m = ends[5, best], ends[6, best], ends[4, best]
    else:
        s.first_speed = max(0.0, s.speed - m.acceleration * m.period_s)
        s.first_turn = _towards(s.turn, 0.0, m.turn_acceleration * m.period_s)
        s.free_m = 0.0


@compiled(numba.boolean(ROWS, *(NUMBER,) * 6))
def all_rays_hit(scene: Array, n: float, e: float, course_rad: float, half_rad: float, length_m: float, goal_m: float) -> bool:
    """The obstacle sampling window: whether every ray of a fan of 5 degree steps meets a standing disc of `scene` (m, >=5).

    Rays are `length_m` long, but no longer than the way to the goal (CPPPEA 2.6).
    """
    half_count = int(half_rad / math.radians(5.0) + 1e-9)
    reach = min(length_m, goal_m)
    for k in range(-half_count, half_count + 1):
        bearing = course_rad + k * math.radians(5.0)
        if ray_free_m(scene, n, e, math.cos(bearing), math.sin(bearing), reach) >= reach:
            return False
    return True

"""Random numbers by counter: the number for (key, i, j, k) is the same whenever and however often it is asked for.

So what is drawn does not depend on what else was drawn: two planners on one seed meet the same noise at the same time.
Source of the mixing: Steele, Lea, Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014 (SplitMix64).
"""

from __future__ import annotations

import math

import numpy as np

from flightapp.core.compiled import compiled

GAMMA = np.uint64(0x9E3779B97F4A7C15)
FIRST = np.uint64(0xBF58476D1CE4E5B9)
SECOND = np.uint64(0x94D049BB133111EB)
A, B, C, D = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)
UNIT = 1.0 / 9007199254740992.0  # 2^-53


@compiled("u8(u8)")
def _mixed(state: np.uint64) -> np.uint64:
    state = (state ^ (state >> A)) * FIRST
    state = (state ^ (state >> B)) * SECOND
    return state ^ (state >> C)


@compiled("f8(u8,i8,i8,i8)")
def uniform(key: int, i: int, j: int, k: int) -> float:
    """In (0, 1)."""
    state = _mixed(np.uint64(key) + np.uint64(i) * GAMMA)
    state = _mixed(state + np.uint64(j) * GAMMA)
    state = _mixed(state + np.uint64(k) * GAMMA)
    return (float(state >> D) + 0.5) * UNIT


@compiled("f8(u8,i8,i8,i8)")
def normal(key: int, i: int, j: int, k: int) -> float:
    """Standard normal (Box-Muller)."""
    size = math.sqrt(-2.0 * math.log(uniform(key, i, j, 2 * k)))
    return size * math.cos(2.0 * math.pi * uniform(key, i, j, 2 * k + 1))

"""Searches for the numbers of a method in a box: random draws, and the grey wolf optimiser of GWO-APF's source.

Both work in the unit cube, so that no coordinate's size counts, and repeat themselves with the same seed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flightapp.core.types import Array

LEADERS = 3
"""Alpha, beta and delta, whom the other wolves follow."""
Cost = Callable[[Array], float]


@dataclass(frozen=True, slots=True)
class Found:
    """place: the best one, within the box; costs: the least so far after each draw or round."""

    place: Array
    costs: tuple[float, ...]


def random_search(cost: Cost, low: Array, high: Array, draws: int, seed: int) -> Found:
    """The best of `draws` places, uniform between `low` and `high` (n,)."""
    generator = np.random.default_rng(seed)
    best, costs = low, [np.inf]
    for _ in range(draws):
        place = low + (high - low) * generator.random(len(low))
        value = cost(place)
        if value < costs[-1]:
            best = place
        costs.append(min(costs[-1], value))
    return Found(best, tuple(costs[1:]))


def grey_wolves(cost: Cost, low: Array, high: Array, wolves: int, rounds: int, seed: int) -> Found:
    """Mirjalili, Mirjalili and Lewis 2014: all follow the mean of what the three best ask for, ever closer.

    X' = mean over the leaders of (X_l - A |C X_l - X|) with A = 2 a r1 - a, C = 2 r2, a from 2 to 0; leaders are the best of
    all rounds. `cost` is called wolves x rounds times.
    """
    generator = np.random.default_rng(seed)
    pack = generator.random((wolves, len(low)))
    leaders, least = np.zeros((LEADERS, len(low))), np.full(LEADERS, np.inf)
    costs = []
    for step in range(rounds):
        values = np.array([cost(low + (high - low) * wolf) for wolf in pack])
        order = np.argsort(np.concatenate((least, values)), kind="stable")[:LEADERS]
        leaders, least = np.concatenate((leaders, pack))[order], np.concatenate((least, values))[order]
        costs.append(float(least[0]))
        reach = 2.0 * (1.0 - step / max(1, rounds - 1))
        ask = reach * (2.0 * generator.random((LEADERS, *pack.shape)) - 1.0)
        weight = 2.0 * generator.random((LEADERS, *pack.shape))
        pack = np.clip((leaders[:, None] - ask * np.abs(weight * leaders[:, None] - pack)).mean(axis=0), 0.0, 1.0)
    return Found(low + (high - low) * leaders[0], tuple(costs))

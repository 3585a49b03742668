"""Where to look next: Latin hypercube first, then Expected Improvement on a Gaussian process, squared-exponential kernel.

A suggestion is a pure function of the seed and of the samples so far, so an interrupted optimisation goes on as if it had not
been interrupted.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from bayes_opt import BayesianOptimization
from bayes_opt.acquisition import ExpectedImprovement
from scipy.stats import qmc
from sklearn.gaussian_process.kernels import RBF, WhiteKernel
from threadpoolctl import threadpool_limits

from flightapp.analysis.tuning.weights import X_MAX, X_MIN
from flightapp.core.types import Array

LENGTH_SCALE_BOUNDS = (0.1, 3.0)
"""Of the square; anything rougher is noise of a finite batch."""
NOISE_BOUNDS = (1e-6, 1.0)
"""Variance over that of all samples, fitted: J of a batch jumps by 100 over the batch's size with each run that fails."""
JITTER = 1e-8
RESTARTS = 1
"""Of the likelihood's maximisation over two hyperparameters; more only cost time."""
IMPROVEMENT_MIN = 0.1
"""Of J, s: less is not searched for, so that the search leaves a plateau."""


@dataclass(frozen=True, slots=True)
class Sample:
    """One evaluated point."""

    x1: float
    x2: float
    j: float


def first_points(count: int, seed: int) -> list[tuple[float, float]]:
    """`count` points of a Latin hypercube over the square."""
    unit = qmc.LatinHypercube(d=2, rng=np.random.default_rng(seed)).random(count)
    return [(float(x1), float(x2)) for x1, x2 in X_MIN + unit * (X_MAX - X_MIN)]


def suggest(samples: Sequence[Sample], seed: int) -> tuple[float, float]:
    """The point of the greatest Expected Improvement over `samples` (at least one)."""
    with threadpool_limits(1):  # small matrices: more threads only wait for one another, and round differently
        point = _optimisation(samples, seed).suggest()
    return float(point["x1"]), float(point["x2"])


def response(samples: Sequence[Sample], points: Array, seed: int) -> Array:
    """J (n,) as the Gaussian process over `samples` has it at `points` (n, 2) = x1, x2."""
    optimisation = _optimisation(samples, seed)
    with warnings.catch_warnings(), threadpool_limits(1):
        warnings.simplefilter("ignore")  # a length scale at its bound is no news
        costs = optimisation.predict([{"x1": float(x1), "x2": float(x2)} for x1, x2 in points])
    return -np.asarray(costs, dtype=np.float64)


def _optimisation(samples: Sequence[Sample], seed: int) -> BayesianOptimization:
    """The library maximises: it is given -J."""
    random_state = int(np.random.SeedSequence([seed, len(samples)]).generate_state(1)[0])
    optimisation = BayesianOptimization(
        f=None,
        pbounds={"x1": (X_MIN, X_MAX), "x2": (X_MIN, X_MAX)},
        acquisition_function=ExpectedImprovement(xi=IMPROVEMENT_MIN),
        random_state=random_state,
        verbose=0,
        allow_duplicate_points=True,
    )
    kernel = RBF(0.3, LENGTH_SCALE_BOUNDS) + WhiteKernel(1e-2, NOISE_BOUNDS)
    optimisation.set_gp_params(kernel=kernel, alpha=JITTER, n_restarts_optimizer=RESTARTS)
    for sample in samples:
        optimisation.space.register({"x1": sample.x1, "x2": sample.x2}, -sample.j)
    return optimisation

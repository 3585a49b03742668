"""The response surface over (alpha, beta) with the samples and the optimum, and how the least J came down."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from flightapp.analysis.campaign.pictures.style import BOUNDARY, new_figure, png
from flightapp.analysis.map_data import INK
from flightapp.analysis.tuning.checkpoint import Evaluation
from flightapp.analysis.tuning.optimiser import response
from flightapp.analysis.tuning.weights import X_MAX, X_MIN, weights_of

GRID = 81
LEVELS = 21
SHOWN_PERCENTILE = 90.0
"""J above this share of the surface is one colour: failing corners would hide the rest."""


def surface_picture(title: str, evaluations: Sequence[Evaluation], initial: int, seed: int) -> bytes:
    """PNG; J as the Gaussian process over all `evaluations` has it, of which the first `initial` are the hypercube's."""
    figure = new_figure(10.4, 4.4)
    surface, descent = figure.subplots(1, 2, width_ratios=(1.25, 1.0))
    best = min(evaluations, key=lambda one: one.j)
    _draw_surface(figure, surface, evaluations, best, seed)
    _draw_descent(descent, evaluations, initial)
    weights = weights_of(best.x1, best.x2)
    found = f"alpha {weights.alpha:.4f}, beta {weights.beta:.4f}, gamma {weights.gamma:.4f}"
    figure.suptitle(f"{title}\nleast J {best.j:.2f} at {found}", fontsize=10)
    return png(figure)


def _draw_surface(figure: Figure, axes: Axes, evaluations: Sequence[Evaluation], best: Evaluation, seed: int) -> None:
    side = np.linspace(X_MIN, X_MAX, GRID)
    x1, x2 = (grid.ravel() for grid in np.meshgrid(side, side))
    costs = response([one.sample() for one in evaluations], np.column_stack([x1, x2]), seed)
    low, high = float(costs.min()), float(np.percentile(costs, SHOWN_PERCENTILE))
    levels = MaxNLocator(LEVELS).tick_values(low, max(high, low + 1e-3))
    shape = (GRID, GRID)
    alpha, beta = x1.reshape(shape), (x2 * (1.0 - x1)).reshape(shape)
    filled = axes.contourf(alpha, beta, costs.reshape(shape), levels=levels, cmap="viridis_r", extend="max")
    figure.colorbar(filled, ax=axes, label="J", format="%g", ticks=MaxNLocator(8))
    samples = np.array([[one.x1, one.x2 * (1.0 - one.x1)] for one in evaluations])
    axes.plot(
        samples[:, 0], samples[:, 1], "o", color="white", markeredgecolor=INK, markeredgewidth=0.6, markersize=3.5, label="sample"
    )
    point = weights_of(best.x1, best.x2)
    axes.plot(
        point.alpha, point.beta, "*", color=BOUNDARY, markeredgecolor="white", markersize=15, label="least J", clip_on=False
    )
    axes.plot([0.0, 1.0], [1.0, 0.0], color=INK, linewidth=0.8)
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(0.0, 1.0)
    axes.set_aspect("equal")
    axes.set_xlabel("alpha (heading)")
    axes.set_ylabel("beta (clearance)")
    axes.legend(loc="upper right")


def _draw_descent(axes: Axes, evaluations: Sequence[Evaluation], initial: int) -> None:
    costs = np.array([one.j for one in evaluations])
    count = np.arange(1, len(costs) + 1)
    axes.plot(count, costs, "o", color="#56b4e9", markersize=3, label="evaluation")
    axes.plot(count, np.minimum.accumulate(costs), color=BOUNDARY, linewidth=1.6, label="least so far")
    axes.axvline(initial + 0.5, color=INK, linewidth=0.8, linestyle="--", label="end of Latin hypercube")
    axes.set_xlabel("evaluation")
    axes.set_ylabel("J")
    axes.set_xlim(0, len(costs) + 1)
    axes.grid(True)
    axes.set_axisbelow(True)
    axes.legend(loc="upper right")

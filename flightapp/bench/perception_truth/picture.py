"""The heat map of detection, width by distance."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np


def draw_detection(cells: list[dict[str, Any]], path: Path) -> None:
    """Write a PNG: found in single frames, and held after half a second."""
    widths = sorted({cell["width_m"] for cell in cells})
    distances = sorted({cell["distance_m"] for cell in cells})
    figure, axes = plt.subplots(1, 2, figsize=(12.0, 4.4), sharey=True, layout="constrained")
    titles = {"frame": "Found in a single frame", "half_second": "Held after half a second"}
    for axis, (kind, title) in zip(axes, titles.items(), strict=True):
        rates = np.full((len(widths), len(distances)), np.nan)
        for cell in cells:
            rates[widths.index(cell["width_m"]), distances.index(cell["distance_m"])] = 100 * cell[kind]["rate"]
        image = axis.imshow(rates, vmin=0, vmax=100, cmap="viridis", aspect="auto", origin="lower")
        for row, column in np.argwhere(np.isfinite(rates)).tolist():
            rate = rates[row, column]
            axis.text(column, row, f"{rate:.0f}", ha="center", va="center", color="white" if rate < 60 else "black")
        axis.set_xticks(range(len(distances)), [f"{distance:g}" for distance in distances])
        axis.set_xlabel("distance of the visible surface, m")
        axis.set_title(title)
    axes[0].set_yticks(range(len(widths)), [f"{100 * width:g}" for width in widths])
    axes[0].set_ylabel("width of the pole, cm")
    figure.colorbar(image, ax=axes, label="% of frames, of trials")
    figure.suptitle("Perception of upright poles, rendered as a D435 sees them: level, hovering")
    figure.savefig(path, dpi=110)
    plt.close(figure)

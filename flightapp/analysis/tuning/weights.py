"""Two free numbers in a square stand for three weights that sum to 1."""

from __future__ import annotations

from dataclasses import dataclass

X_MIN, X_MAX = 0.01, 0.99


@dataclass(frozen=True, slots=True)
class Weights:
    """alpha (heading), beta (clearance), gamma (velocity)."""

    alpha: float
    beta: float
    gamma: float

    def as_parameters(self) -> dict[str, float]:
        """As fields of the planner's parameters."""
        return {"weight_heading": self.alpha, "weight_clearance": self.beta, "weight_velocity": self.gamma}


def weights_of(x1: float, x2: float) -> Weights:
    """alpha = x1, beta = x2 (1 - x1), gamma = 1 - alpha - beta, which is positive for x1, x2 < 1."""
    alpha, beta = x1, x2 * (1.0 - x1)
    return Weights(alpha, beta, 1.0 - alpha - beta)

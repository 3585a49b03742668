"""Scoring terms of sampled motions, shared by the strategies: raw scores over whole candidate arrays, apart from weights."""

from flightapp.planning.critics.clearance import clearance, clearance_score
from flightapp.planning.critics.heading import heading, heading_score
from flightapp.planning.critics.memory import memory, memory_score
from flightapp.planning.critics.scoring import best, best_candidate
from flightapp.planning.critics.velocity import velocity, velocity_score

__all__ = [
    "best",
    "best_candidate",
    "clearance",
    "clearance_score",
    "heading",
    "heading_score",
    "memory",
    "memory_score",
    "velocity",
    "velocity_score",
]

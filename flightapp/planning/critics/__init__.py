"""Scoring terms of sampled motions, shared by the strategies: raw scores over whole candidate arrays, apart from weights."""

from flightapp.planning.critics.clearance import clearance_score
from flightapp.planning.critics.heading import heading_score
from flightapp.planning.critics.memory import memory_score
from flightapp.planning.critics.scoring import best_candidate
from flightapp.planning.critics.velocity import velocity_score

__all__ = ["best_candidate", "clearance_score", "heading_score", "memory_score", "velocity_score"]

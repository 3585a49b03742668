"""Scoring terms of sampled motions, shared by the strategies: raw scores over whole candidate arrays, apart from weights."""

from flightapp.planning.critics.clearance import clearance
from flightapp.planning.critics.heading import heading
from flightapp.planning.critics.memory import memory
from flightapp.planning.critics.scoring import best
from flightapp.planning.critics.velocity import velocity

__all__ = ["best", "clearance", "heading", "memory", "velocity"]

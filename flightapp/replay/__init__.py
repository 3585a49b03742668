"""Recorded flights decided again: today's planner and supervisor on exactly what they were given then."""

from flightapp.replay.replay import Wanted, replay

__all__ = ["Wanted", "replay"]

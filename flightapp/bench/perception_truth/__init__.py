"""Perception against the renderer's exact scene: what it finds, what it invents, what it misses."""

from flightapp.bench.perception_truth.run import run_perception_truth

__all__ = ["run_perception_truth"]

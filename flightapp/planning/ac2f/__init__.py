"""AC2F: adaptive coarse-to-fine pursuit (Zhang, Zhou, Xue, Xue, Sensors 2026, 26(12), 3790)."""

from flightapp.planning.ac2f.parameters import Ac2fParameters
from flightapp.planning.ac2f.planner import Ac2fPlanner

__all__ = ["Ac2fParameters", "Ac2fPlanner"]

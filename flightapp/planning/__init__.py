"""Planning: strategies and evader policies as pure, seeded functions of observations."""

from flightapp.planning.registry import evader_names, file_parameters, make_evader, make_planner, planner_names

__all__ = ["evader_names", "file_parameters", "make_evader", "make_planner", "planner_names"]

"""Planning: strategies and evader policies as pure, seeded functions of observations.

`make_planner` and the other names come from `registry` at first use: kernels below this package are compiled and imported
without the whole of it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flightapp.planning.registry import evader_names, file_parameters, make_evader, make_planner, planner_names

__all__ = ["evader_names", "file_parameters", "make_evader", "make_planner", "planner_names"]


def __getattr__(name: str) -> object:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from flightapp.planning import registry

    return getattr(registry, name)

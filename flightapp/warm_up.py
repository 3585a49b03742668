"""`python -m flightapp.warm_up`: compile the numerical kernels into their cache, on the machine that will fly.

Numba keys its cache by CPU model, so this belongs into the install step on the flight computer. It compiles on one core; so
several processes first import parts of the application that do not need each other, then what is built from them.
"""

import gc
import importlib
import os
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

PARTS = (
    "flightapp.planning.ac2f.fine",
    "flightapp.planning.ac2f.surroundings",
    "flightapp.planning.ac2f.guidance",
    "flightapp.planning.ac2f.reactive",
    "flightapp.planning.ac2f.judge",
)
"""Longest first."""
WHOLE = (
    "flightapp.sim.batch",
    "flightapp.sim.batch.volume.world",
    "flightapp.planning.ac2f.planner",
    "flightapp.planning.ac2f.volume.planner",
    "perception.synthetic.depth_renderer",
    "perception.tracking.tracker",
    "perception.extraction.extractor",
    "flightapp.planning.evasion.avoidance",
    "flightapp.estimation.target_filter",
    "flightapp.safety.supervisor",
    "flightapp.sim.control_study.flight",
    "flightapp.control.tracker",
    "perception.free_space",
    "flightapp.sim.world",
    "flightapp.planning.evasion.boundary_run",
    "flightapp.planning.evasion.voronoi_cell",
    "flightapp.planning.encirclement.planner",
    "flightapp.planning.hunting.planner",
    "flightapp.planning.path_planning.rrt_star.planner",
    "flightapp.planning.adaptive_apf.planner",
    "flightapp.sim.field_study.flight",
)
OBJECTS = 100_000
"""New objects between two collections of garbage: at Python's 700 they take a sixth of the time."""


def warm_up() -> None:
    """Fill the cache; where it is full, only load it."""
    cores = len(os.sched_getaffinity(0))
    with ProcessPoolExecutor(cores, get_context("spawn"), gc.set_threshold, (OBJECTS,)) as processes:
        for modules in (PARTS, WHOLE):
            list(processes.map(_compile, modules))


def _compile(module: str) -> None:
    importlib.import_module(module)


if __name__ == "__main__":
    warm_up()

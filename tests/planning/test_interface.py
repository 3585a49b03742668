"""The names that strategies and studies outside this repository use."""

from __future__ import annotations

import subprocess
import sys

import flightapp.planning
from flightapp.planning import evader_names, make_evader, make_planner, planner_names
from tests.planning.closed_loop import limits


def test_planning_offers_its_interface() -> None:
    assert set(flightapp.planning.__all__) >= {"make_planner", "planner_names"}
    assert "ac2f" in planner_names()
    assert callable(make_planner("ac2f", limits=limits()).step)
    assert callable(make_evader(evader_names()[0], limits=limits()).step)


def test_a_part_of_planning_is_imported_without_the_whole() -> None:
    check = "import sys, flightapp.planning.ac2f.braking; sys.exit('flightapp.planning.registry' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", check], check=False).returncode == 0

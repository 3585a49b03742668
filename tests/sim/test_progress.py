"""The lines of a simulated mission's progress."""

from __future__ import annotations

import pytest

from flightapp.sim.progress import Progress
from tests.watch.scenes import state


def test_a_vehicle_whose_process_has_failed_is_not_shown_as_flying_on(capsys: pytest.CaptureFixture[str]) -> None:
    states = {"p1": state("p1", phase="pursue"), "p2": state("p2", phase="pursue")}
    with Progress("mission") as progress:
        progress.show(1.0, states)
        progress.show(1.1, states, failed={"p2"})
    lines = capsys.readouterr().err.splitlines()
    before, after = lines[:2], lines[2:]
    assert all("pursue" in line for line in before)
    assert len(after) == 2, "a failure is shown at once"
    assert "pursue" in after[0]
    assert after[1].split()[2:] == ["p2", "ended"]

"""`--live [PORT]` of sim and fly."""

from __future__ import annotations

import pytest
from typer.testing import CliRunner

from flightapp.cli import app

BEFORE = ["missions/none.toml", "--profile", "profiles/sim.toml", "--vehicle", "p1"]


@pytest.mark.parametrize("live", [["--live"], ["--live", "0"], ["--live", "9000"], ["--live", "--live-address", "0.0.0.0"], []])
def test_the_port_may_be_left_out(live: list[str]) -> None:
    """The mission does not exist: whatever is said after that has been understood."""
    result = CliRunner().invoke(app, ["fly", *BEFORE, *live])
    assert "none.toml: no such file" in str(result.exception)


@pytest.mark.parametrize("port", ["-1", "65536"])
@pytest.mark.parametrize("command", [["fly", *BEFORE], ["sim", "missions/none.toml"]])
def test_a_port_that_cannot_be_is_refused(command: list[str], port: str) -> None:
    result = CliRunner().invoke(app, [*command, "--live", port])
    assert result.exit_code == 2
    assert "Invalid value for '--live'" in result.output

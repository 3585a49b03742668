"""Shared by the tests of the page."""

from pathlib import Path

import pytest

from flightapp.analysis import report
from tests.analysis.synthetic_run import write_run


@pytest.fixture(scope="session")
def reported_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run with all that the command can write, compared with another one: a vehicle less, the truth cut short."""
    folder = write_run(tmp_path_factory.mktemp("page") / "run")
    other = folder.parent / "shorter"
    other.mkdir()
    for name in ("p1.mcap", "e1.mcap", "truth.mcap"):
        content = (folder / name).read_bytes()
        (other / name).write_bytes(content if name != "truth.mcap" else content[: len(content) // 2])
    report([folder], compare=[other], as_csv=True, as_parquet=True)
    return folder

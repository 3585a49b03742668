"""Fixtures of the perception tests."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.perception.scenes import MakeStage, Stage


@pytest.fixture
def scene() -> MakeStage:
    def make(
        cylinders: list[tuple[float, ...]] | None = None,
        boxes: list[tuple[float, ...]] | None = None,
        noise: bool = True,
        seed: int = 1,
    ) -> Stage:
        return Stage(cylinders or [], boxes or [], noise, seed)

    return make


@pytest.fixture
def depth_data() -> Path:
    """The folder of real depth frames; skips where it is absent."""
    root = Path(os.environ.get("FLIGHTAPP_DATA", Path(__file__).parents[2] / ".." / "shared" / "data"))
    folder = (root / "depth").resolve()
    if not folder.is_dir():
        pytest.skip("no real depth frames here; name their folder in FLIGHTAPP_DATA")
    return folder

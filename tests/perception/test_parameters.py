"""Parameters that contradict each other are refused with a sentence."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from perception.parameters import PerceptionParameters


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"disc_radius_max_m": 0.1, "surface_tolerance_m": 0.05}, "disc_radius_max_m = 0.1 must not be less than"),
        ({"surface_tolerance_m": 0.7}, "surface_tolerance_m = 0.7 must not exceed disc_radius_max_m = 0.6"),
        ({"stride_px": 0}, "greater than or equal to 1"),
        ({"band_m": float("nan")}, "finite number"),
        ({"bandm": 1.0}, "Extra inputs are not permitted"),
    ],
)
def test_nonsense_is_refused(changes: dict[str, float], said: str) -> None:
    with pytest.raises(ValidationError, match=said):
        PerceptionParameters(**changes)

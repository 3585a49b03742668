"""Scenario files: one on top of another, overrides, and errors that say what would be right."""

from __future__ import annotations

from pathlib import Path

import pytest

from flightapp.core.errors import InputError
from flightapp.sim.batch import load_scenario
from tests.sim.batch.stubs import SCENARIOS


def test_every_scenario_of_the_repository_loads_under_its_name() -> None:
    files = sorted(SCENARIOS.glob("*.toml"))
    assert len(files) >= 6
    assert [load_scenario(file).name for file in files] == [file.stem for file in files]


def test_a_file_extends_another_table_by_table() -> None:
    base, camera = load_scenario(SCENARIOS / "a2-dense.toml"), load_scenario(SCENARIOS / "a2-dense-d435.toml")
    assert camera.layout == base.layout
    assert camera.sensing.field_of_view_deg == 87.0
    assert camera.planner.parameters["response_lag_s"] == base.planner.parameters["response_lag_s"]
    assert camera.planner.parameters["reaction_s"] != base.planner.parameters["reaction_s"]


def test_overrides_are_toml_values_or_plain_text() -> None:
    overrides = {"sensing.field_of_view_deg": "120", "evader.policy": "hover", "evader.parameters": "{}", "evader.solid": "true"}
    changed = load_scenario(SCENARIOS / "a2-dense.toml", overrides)
    assert (changed.sensing.field_of_view_deg, changed.evader.policy, changed.evader.solid) == (120.0, "hover", True)


@pytest.mark.parametrize(
    ("field", "value", "sentence"),
    [
        ("sensing.field_of_view_deg", "400", "sensing.field_of_view_deg = 400: must be at most 360"),
        ("pursuers.model", "rocket", "pursuers.model = 'rocket': must be 'unicycle', 'multirotor' or 'single-integrator'"),
        ("sensing.rnge_m", "5", "sensing.rnge_m = 5: unknown field; did you mean 'range_m'?"),
        ("family", "desert", "family = 'desert': must be one of dense, scatter, suburban, terminal, u-trap"),
        ("layout.depth_m", "5", "layout.depth_m = 5: unknown field"),
        ("sub_step_s", "0.03", "sub_step_s = 0.03: control_period_s = 0.1 must be a multiple of it"),
        ("wind.gust_m_s", "2", "wind: pursuers.model = 'unicycle' does not feel wind"),
        ("name.first", "5", "name.first = 5: 'name' is a value, not a table"),
    ],
)
def test_what_is_wrong_is_one_sentence(field: str, value: str, sentence: str) -> None:
    with pytest.raises(InputError) as refusal:
        load_scenario(SCENARIOS / "a2-dense.toml", {field: value})
    assert sentence in str(refusal.value)
    assert "a2-dense.toml: " in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_files_that_extend_one_another_in_a_circle_are_refused(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text('extends = "b.toml"')
    (tmp_path / "b.toml").write_text('extends = "a.toml"')
    with pytest.raises(InputError, match="in a circle"):
        load_scenario(tmp_path / "a.toml")
    (tmp_path / "c.toml").write_text('extends = "nowhere.toml"')
    with pytest.raises(InputError, match=r"nowhere\.toml: no such file"):
        load_scenario(tmp_path / "c.toml")

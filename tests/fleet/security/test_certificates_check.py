"""Preflight's check of the certificates."""

from __future__ import annotations

from pathlib import Path

import pytest

from flightapp.fleet.security.credentials import Credentials
from flightapp.preflight.checks.certificates import judge
from flightapp.preflight.result import Level
from tests.preflight.good_facts import NOW_S, PROFILE, VEHICLE, good_facts

DAY_S = 86400.0


def credentials(name: str = VEHICLE.name, begins_s: float = NOW_S - DAY_S, ends_s: float = NOW_S + 14 * DAY_S) -> Credentials:
    return Credentials(Path("keys") / name, name, (), begins_s, ends_s)


@pytest.mark.parametrize(
    ("own", "level", "words"),
    [
        (credentials(), Level.PASSED, f"'{VEHICLE.name}', valid until 1970-01-15 00:16 UTC"),
        (credentials(name="p9"), Level.FAILED, "those of 'p9'"),
        (credentials(name="operator"), Level.FAILED, "those of 'operator'"),
        (credentials(begins_s=NOW_S + 60.0), Level.FAILED, "this machine's clock says 1970-01-01 00:16 UTC"),
        (credentials(ends_s=NOW_S), Level.FAILED, "expired at"),
        (credentials(ends_s=NOW_S + 1800.0), Level.FAILED, "less than an hour"),
        (credentials(ends_s=NOW_S + 7200.0), Level.WARNING, "less than a day"),
        (None, Level.NOTED, "anybody on the network can join"),
    ],
)
def test_certificates_that_the_others_would_refuse_keep_the_vehicle_on_the_ground(
    own: Credentials | None, level: Level, words: str
) -> None:
    (result,) = judge(good_facts(credentials=own))
    assert result.level is level
    assert words in result.found
    assert result.reason
    assert bool(result.remedy) is (level >= Level.WARNING)


def test_certificates_without_access_control_are_worth_a_warning() -> None:
    network = PROFILE.network.model_copy(update={"access_control": False})
    (result,) = judge(good_facts(credentials=credentials(), profile=PROFILE.model_copy(update={"network": network})))
    assert result.level is Level.WARNING
    assert "speak as every other" in result.found

"""Losses are judged against the states that were really sent here, which are fewer to a mate far away."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np

from flightapp.analysis.analysers.link import examine
from flightapp.analysis.analysers.subject import Heard, Subject
from flightapp.analysis.findings import Finding
from flightapp.config.profile import load_profile
from flightapp.recording.phases import Window

PROFILE = load_profile(Path(__file__).parents[3] / "profiles/sim.toml")
FLOWN_S = 20.0


def found(lost: int, taken: float) -> Finding:
    """In a flight in which so many states of p2 did not come and so many came; nan: not recorded."""
    t_s = np.linspace(0.0, FLOWN_S, 201)
    share = t_s / FLOWN_S
    zeros = np.zeros(len(t_s))
    heard = Heard(t_s, zeros + 0.1, lost * share, taken * share, zeros, np.zeros((len(t_s), 3)))
    p1, p2 = SimpleNamespace(name="p1"), SimpleNamespace(name="p2")
    subject = SimpleNamespace(
        name="p1",
        mission=SimpleNamespace(vehicles=(p1, p2)),
        run=SimpleNamespace(vehicles=()),
        airborne=Window(0.0, FLOWN_S),
        heard={"p2": heard},
        profile=PROFILE,
    )
    [finding] = examine(cast(Subject, subject))
    return finding


def test_a_third_lost_of_what_a_distant_mate_is_told_at_5_hz_is_a_warning() -> None:
    finding = found(lost=33, taken=67.0)
    assert finding.title == "messages lost"
    assert finding.evidence["lost_share"] == 0.33
    assert "33 of about 100 states" in finding.text


def test_the_same_number_of_losses_at_the_full_rate_is_none_nor_in_an_older_recording() -> None:
    assert found(lost=33, taken=367.0).title == "p2 heard"
    assert found(lost=33, taken=math.nan).title == "p2 heard"

"""The comparison of flights in wind: what is paired, and what is said of it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np

from tools.wind_flights import WITH, WITHOUT, Flown, median_difference, paired, summary

ROOT = Path(__file__).parents[2]


def flown(seed: int, controller: str, pursuit_s: float, outcome: str = "captured") -> Flown:
    return Flown(seed, controller, "px4", outcome, pursuit_s, 1.5, 1.2, 0.8, 4.0)


def test_flights_are_compared_seed_by_seed_and_halves_of_pairs_left_out() -> None:
    flights = [flown(seed, WITHOUT, 20.0 + seed) for seed in range(8)]
    flights += [flown(seed, WITH, 18.0 + seed, "captured" if seed else "time limit") for seed in range(7)]
    flights.append(flown(7, WITH, 0.0, "no pursuit"))
    assert len(paired(flights)) == 7
    said = "\n".join(summary(flights))
    assert "7 pairs" in said
    assert "1 seeds left out" in said
    assert "captured without / with: 7 / 6 of 7; only without 1, only with 0" in said
    assert "pursuit, s: 23.00 / 21.00, difference -2.00 [-2.00, -2.00]" in said


def test_the_interval_holds_the_median_and_tells_noise_from_a_difference() -> None:
    random = np.random.default_rng(1)
    noise, shifted = random.normal(0.0, 1.0, 20), random.normal(-2.0, 1.0, 20)
    middle, low, high = median_difference(noise)
    assert low <= middle <= high
    assert low < 0.0 < high
    assert median_difference(shifted)[2] < 0.0


def test_a_mission_that_cannot_be_switched_is_refused_in_one_sentence() -> None:
    command = [sys.executable, "tools/wind_flights.py", "--mission", "missions/hover.toml"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "has no line 'controller = \"aadrc-smc\"'" in done.stderr

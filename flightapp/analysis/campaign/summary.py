"""The figures of a campaign: for machines as fixed keys, with medians and shares beside them for the table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from flightapp.analysis.campaign.statistics import two_proportion_p_value, wilson_interval
from flightapp.sim.batch.result import RunResult
from flightapp.sim.batch.scenario import Scenario

Summary = dict[str, Any]


def summarise(scenario: Scenario, seeds: str, planners: Sequence[str], results: Sequence[RunResult]) -> Summary:
    """{scenario, seeds, planners: [figures]} in the order of `planners`; planners without any run are left out."""
    flown = {planner: [result for result in results if result.planner == planner] for planner in planners}
    first = flown[planners[0]]
    sections = [
        planner_figures(planner, runs, None if planner == planners[0] else first, scenario.pursuers.speed_max_m_s)
        for planner, runs in flown.items()
        if runs
    ]
    return {"scenario": scenario.name, "seeds": seeds, "planners": sections}


def planner_figures(
    planner: str, runs: Sequence[RunResult], reference: Sequence[RunResult] | None, speed_max_m_s: float
) -> Summary:
    """The figures of one planner. Times, paths and clearances are means over successful runs, the clearance their least.

    reference: runs of the planner that the p-value compares with. speed_max_m_s: at which the shortest path would be flown.
    """
    captured = [run for run in runs if run.outcome == "captured"]
    figures: Summary = {
        "planner": planner,
        "runs": len(runs),
        "success_rate": len(captured) / len(runs),
        "success_ci95": list(wilson_interval(len(captured), len(runs))),
        "p_value": None if not reference else _p_value(captured, runs, reference),
        "collision_rate": _share(runs, "collided"),
        "escape_rate": _share(runs, "escaped"),
        "timeout_rate": _share(runs, "timed_out"),
    }
    for name in MEAN_FIELDS:
        figures[name] = _figure(np.mean, _values(captured, name))
    figures["min_clearance_m"] = _figure(np.min, _values(captured, "min_clearance_m"))
    figures["min_separation_m"] = _figure(np.min, _values(runs, "min_separation_m"))
    figures["encircled_at_capture_rate"] = _figure(np.mean, _values(captured, "encircled_at_capture"))
    figures["encircled_share"] = _figure(np.mean, _values(runs, "encircled_share"))
    figures["encircled_first_s"] = _figure(np.mean, _values(runs, "encircled_first_s"))
    decisions_ms = np.concatenate([run.decision_ns for run in runs]) * 1e-6
    figures["decision_ms"] = {name: _figure(lambda ms, q=q: np.percentile(ms, q), decisions_ms) for name, q in _PERCENTILES}
    wall_s = sum(run.sim_wall_ns for run in runs) * 1e-9
    figures["simulated_s_per_s"] = sum(run.duration_s for run in runs) / wall_s if wall_s > 0 else None
    ratios = _path_time_ratios(captured, speed_max_m_s)
    if len(ratios):
        figures["time_over_shortest_path"] = {"median": _figure(np.median, ratios), "max": _figure(np.max, ratios)}
    return figures


MEAN_FIELDS = ("capture_time_s", "path_length_m", "mean_jerk_m_s3", "boundary_distance_m", "travel_m", "turning_rad")
_PERCENTILES = (("p50", 50.0), ("p99", 99.0))


def planner_details(runs: Sequence[RunResult]) -> Summary:
    """What the table shows beside the figures: medians over successful runs; of all runs modes, flags, collisions."""
    captured = [run for run in runs if run.outcome == "captured"]
    modes = sorted({mode for run in runs for mode in run.mode_share})
    flags = sorted({flag for run in runs for flag in run.flag_share})
    seconds, decisions = sum(run.duration_s for run in runs), max(1, sum(run.decisions for run in runs))
    return {
        "median": {name: _figure(np.median, _values(captured, name)) for name in (*MEAN_FIELDS, "min_clearance_m")},
        "mode_share": {mode: sum(run.mode_share.get(mode, 0.0) * run.duration_s for run in runs) / seconds for mode in modes},
        "flag_share": {flag: sum(run.flag_share.get(flag, 0.0) * run.decisions for run in runs) / decisions for flag in flags},
        "outcomes": dict(sorted(Counter(run.outcome for run in runs).items())),
        "collided_with": dict(sorted(Counter(run.collided_with for run in runs if run.outcome == "collided").items())),
        "failed_seeds": [run.seed for run in runs if run.outcome != "captured"],
    }


def _p_value(captured: Sequence[RunResult], runs: Sequence[RunResult], reference: Sequence[RunResult]) -> float:
    successes = sum(run.outcome == "captured" for run in reference)
    return two_proportion_p_value(len(captured), len(runs), successes, len(reference))


def _share(runs: Sequence[RunResult], outcome: str) -> float:
    return sum(run.outcome == outcome for run in runs) / len(runs)


def _path_time_ratios(captured: Sequence[RunResult], speed_max_m_s: float) -> np.ndarray:
    """Capture time over the time in which the shortest path is flown at top speed."""
    return np.array(
        [
            run.capture_time_s * speed_max_m_s / run.shortest_path_m
            for run in captured
            if run.capture_time_s is not None and run.shortest_path_m
        ]
    )


def _values(runs: Sequence[RunResult], name: str) -> np.ndarray:
    """The finite values of one field."""
    values = np.array([getattr(run, name) for run in runs], dtype=np.float64)
    return values[np.isfinite(values)]


def _figure(statistic: Any, values: np.ndarray) -> float | None:
    """JSON knows no NaN: None without values."""
    return float(statistic(values)) if len(values) else None

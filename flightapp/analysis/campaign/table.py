"""table.md: a campaign's figures for a person to read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from flightapp.analysis.campaign.summary import Summary

DASH = "–"


def markdown(summary: Summary, details: Mapping[str, Summary]) -> str:
    """Outcomes, then figures over successful runs as mean (median), then computation; one row a planner."""
    planners: list[Summary] = summary["planners"]
    ratios = any("time_over_shortest_path" in one for one in planners)
    figures = [_figures(one, details[one["planner"]]["median"]) + ([_ratio(one)] if ratios else []) for one in planners]
    parts = [
        f"# {summary['scenario']}, seeds {summary['seeds']}",
        aligned(OUTCOME_HEADINGS, [_outcomes(one) for one in planners]),
        "Success: captured without collision, 95 % Wilson interval; p: two-proportion z-test against the first planner.",
        aligned([*FIGURE_HEADINGS, RATIO_HEADING] if ratios else FIGURE_HEADINGS, figures),
        "Over successful runs: mean (median); clearance: least (median).",
        aligned(TEAM_HEADINGS, [_team(one) for one in planners]),
        "Encircled: the evader inside the hull of at least three pursuers; at the capture: share of captures; of the time: mean "
        "of all runs. Separation: the least of all runs, between centres. Travel and turning: sums over the team, means over "
        "successful runs.",
        aligned(COMPUTATION_HEADINGS, [_computation(one, details[one["planner"]]["mode_share"]) for one in planners]),
        "p50, p99: processor time of a decision.",
    ]
    flagged = [_flags(one["planner"], shares) for one in planners if (shares := details[one["planner"]]["flag_share"])]
    if flagged:
        parts += [
            aligned(FLAG_HEADINGS, flagged),
            "Flags: what is not as the strategy wants it, and the share of decisions that tell it.",
        ]
    return "\n\n".join(parts) + "\n"


OUTCOME_HEADINGS = ("planner", "runs", "success %", "95 % interval", "p", "collided %", "escaped %", "timed out %")
FIGURE_HEADINGS = ("planner", "time s", "path m", "jerk m/s3", "d_min m", "clearance m")
TEAM_HEADINGS = ("planner", "encircled % at capture", "% of the time", "first s", "separation m", "travel m", "turning rad")
FLAG_HEADINGS = ("planner", "flags, % of decisions")
RATIO_HEADING = "time / shortest"
COMPUTATION_HEADINGS = ("planner", "p50 ms", "p99 ms", "simulated s/s", "modes")


def _outcomes(one: Summary) -> list[str]:
    low, high = one["success_ci95"]
    return [
        one["planner"],
        str(one["runs"]),
        _percent(one["success_rate"]),
        f"{_percent(low)} to {_percent(high)}",
        DASH if one["p_value"] is None else f"{one['p_value']:.2g}",
        _percent(one["collision_rate"]),
        _percent(one["escape_rate"]),
        _percent(one["timeout_rate"]),
    ]


def _figures(one: Summary, median: Summary) -> list[str]:
    return [
        one["planner"],
        *(
            _pair(one[name], median[name])
            for name in ("capture_time_s", "path_length_m", "mean_jerk_m_s3", "boundary_distance_m", "min_clearance_m")
        ),
    ]


def _team(one: Summary) -> list[str]:
    at_capture = one["encircled_at_capture_rate"]
    return [
        one["planner"],
        DASH if at_capture is None else _percent(at_capture),
        _percent(one["encircled_share"]),
        _number(one["encircled_first_s"], 2),
        _number(one["min_separation_m"], 2),
        _number(one["travel_m"], 1),
        _number(one["turning_rad"], 1),
    ]


def _ratio(one: Summary) -> str:
    """Capture time over that of the shortest path at top speed, where the layout knows it."""
    ratio = one.get("time_over_shortest_path")
    return DASH if ratio is None else f"median {ratio['median']:.2f}, most {ratio['max']:.2f}"


def _computation(one: Summary, modes: Mapping[str, float]) -> list[str]:
    shares = sorted(modes.items(), key=lambda item: -item[1])
    return [
        one["planner"],
        _number(one["decision_ms"]["p50"], 3),
        _number(one["decision_ms"]["p99"], 3),
        _number(one["simulated_s_per_s"], 0),
        ", ".join(f"{mode} {_percent(share)} %" for mode, share in shares),
    ]


def _flags(planner: str, shares: Mapping[str, float]) -> list[str]:
    return [planner, ", ".join(f"{flag} {_percent(share)}" for flag, share in sorted(shares.items(), key=lambda item: -item[1]))]


def aligned(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table, columns in line; the first is text."""
    widths = [max(3, *(len(row[column]) for row in (headings, *rows))) for column in range(len(headings))]
    rule = ["-" * width if column == 0 else "-" * (width - 1) + ":" for column, width in enumerate(widths)]
    return "\n".join(_line(row, widths) for row in (headings, rule, *rows))


def _line(cells: Sequence[str], widths: Sequence[int]) -> str:
    first, *others = (f"{cell:{'<' if column == 0 else '>'}{widths[column]}}" for column, cell in enumerate(cells))
    return f"| {' | '.join((first, *others))} |"


def _percent(share: float) -> str:
    return f"{100 * share:.1f}"


def _pair(value: float | None, median: float | None) -> str:
    return DASH if value is None else f"{_number(value, 2)} ({_number(median, 2)})"


def _number(value: float | None, decimals: int) -> str:
    return DASH if value is None else f"{value:.{decimals}f}"

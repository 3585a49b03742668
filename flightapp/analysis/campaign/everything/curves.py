"""Pictures of the grid: success and smallest distances against a quantity that its scenarios differ in."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from flightapp.analysis.campaign.everything.curve import Curve, number_of
from flightapp.analysis.campaign.everything.figures import Figures
from flightapp.analysis.campaign.pictures.against import Panel, against_picture
from flightapp.sim.batch.scenario import Scenario

SUCCESS = (
    Panel("captured, %", "success_rate", "success_ci95_low", "success_ci95_high", 100.0, 103.0),
    Panel("encircled at capture, %", "encircled_at_capture_rate", factor=100.0, top=103.0),
)
DISTANCES = (
    Panel("to obstacles (surfaces), m\nmedian of runs; dotted: least", "median_clearance_m", "min_clearance_m"),
    Panel("between pursuers (centres), m\nmedian of runs; dotted: least", "median_separation_m", "min_separation_m"),
)


def curve_pictures(
    curves: Sequence[Curve], scenarios: Sequence[Scenario], planners: Sequence[str], figures: Sequence[Figures]
) -> Iterator[tuple[str, bytes]]:
    """(name, PNG) of every curve that has two scenarios with runs."""
    for curve in curves:
        found = lines(curve, scenarios, planners, figures)
        if found:
            runs = {entry["runs"] for points in found.values() for _, entry in points}
            count = f"{min(runs)}" if len(runs) == 1 else f"{min(runs)} to {max(runs)}"
            title = f"{curve.title}; {count} runs a point"
            yield f"{curve.name}-success.png", against_picture(title, curve.label, SUCCESS, found)
            yield f"{curve.name}-distances.png", against_picture(title, curve.label, DISTANCES, found)


def lines(
    curve: Curve, scenarios: Sequence[Scenario], planners: Sequence[str], figures: Sequence[Figures]
) -> dict[str, list[tuple[float, Figures]]]:
    """Of every planner with figures in two of the curve's scenarios: (number, figures), the number ascending."""
    found = {(entry["scenario"], entry["planner"]): entry for entry in figures}
    at = sorted((number_of(scenario, curve), scenario.name) for scenario in scenarios if scenario.name in curve.scenarios)
    drawn = {planner: [(x, found[name, planner]) for x, name in at if (name, planner) in found] for planner in planners}
    return {planner: points for planner, points in drawn.items() if len(points) > 1}

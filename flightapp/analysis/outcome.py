"""One outcome for the fleet out of what each vehicle recorded."""

from __future__ import annotations

from collections.abc import Sequence

from flightapp.analysis.run import Run, VehicleRun
from flightapp.recording.phases import Phases


def fold_outcome(run: Run) -> str | None:
    """The run's outcome; None if no vehicle recorded one.

    `fault` if any vehicle says so; else `captured` if a pursuer says so (without known roles: any vehicle); else the first of
    `escaped`, `timeout`, `aborted` that any vehicle says: one vehicle's abort does not end the pursuit of the others.
    """
    told = {vehicle.phases.outcome for vehicle in run.vehicles}
    if "fault" in told:
        return "fault"
    if any(vehicle.phases.outcome == "captured" for vehicle in pursuers_of(run)):
        return "captured"
    return next((outcome for outcome in ("escaped", "timeout", "aborted") if outcome in told), None)


def pursuers_of(run: Run) -> Sequence[VehicleRun]:
    """The pursuers; every vehicle where no role is known."""
    known = [vehicle for vehicle in run.vehicles if vehicle.role is not None]
    return run.with_role("pursuer") if known else run.vehicles


def pursuit_start_s(run: Run) -> float | None:
    """When the first pursuer began to pursue, fleet time."""
    return min((start for vehicle in pursuers_of(run) if (start := _pursue_s(vehicle.phases)) is not None), default=None)


def captured_s(run: Run) -> float | None:
    """When a pursuer first knew the evader to be captured, fleet time; None unless the run's outcome is `captured`."""
    if fold_outcome(run) != "captured":
        return None
    times = [vehicle.phases.outcome_s for vehicle in pursuers_of(run) if vehicle.phases.outcome == "captured"]
    return min((t_s for t_s in times if t_s is not None), default=None)


def captured_by(run: Run) -> list[str] | None:
    """Who captured the evader, as told by whoever concluded it first; None unless captured, or where no recording tells."""
    if fold_outcome(run) != "captured":
        return None
    events = [event for vehicle in pursuers_of(run) for event in vehicle.recording.topic("/event").messages]
    told = [(event["t_s"], event["data"]["captured_by"]) for event in events if "captured_by" in (event.get("data") or {})]
    return list(min(told)[1]) if told else None


def _pursue_s(phases: Phases) -> float | None:
    return next((t_s for t_s, phase in phases.starts if phase == "pursue"), None)

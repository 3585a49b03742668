"""summary.json: the figures of one run."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import orjson

from flightapp.analysis import metrics
from flightapp.analysis.analysers import ANALYSERS
from flightapp.analysis.analysers.analyser import examine_run
from flightapp.analysis.findings import as_json
from flightapp.analysis.outcome import captured_by, captured_s, fold_outcome, pursuers_of, pursuit_start_s
from flightapp.analysis.run import Run, load_run
from flightapp.analysis.verdict import one_line, verdict_of
from flightapp.sim.world import World

Summary = dict[str, Any]


def summarise(run: Run) -> Summary:
    """All figures of the run (see `metrics` for the windows and `outcome` for the fold). null: not known."""
    world = _world(run)
    vehicles = {vehicle.name: metrics.vehicle_figures(vehicle, world) for vehicle in run.vehicles}
    pursuers = [vehicles[vehicle.name] for vehicle in pursuers_of(run)]
    start_s, end_s, by = pursuit_start_s(run), captured_s(run), captured_by(run)
    summary = {
        "mission": _mission_name(run),
        "seed": _seed(run),
        "outcome": fold_outcome(run),
        "captured_by": by,
        "capturers": None if by is None else len(by),
        "capture_time_s": None if start_s is None or end_s is None else end_s - start_s,
        "path_length_m": _mean(pursuers, "path_length_m"),
        "mean_jerk_m_s3": _mean(pursuers, "mean_jerk_m_s3"),
        "min_obstacle_clearance_m": _least(pursuers, "min_obstacle_clearance_m"),
        "clearance_wanted_m": _clearance_wanted_m(run),
        "min_separation_m": metrics.min_separation_m(run),
        "separation_required_m": _separation_required_m(run),
        "min_target_distance_m": metrics.min_target_distance_m(run),
        **metrics.boundary_figures(run),
        **metrics.fleet_latencies(run),
        "setpoint_rate_hz": _least(pursuers, "setpoint_rate_hz"),
        "setpoint_gap_p99_ms": _greatest(list(vehicles.values()), "setpoint_gap_p99_ms"),
        "setpoint_gap_max_ms": _greatest(list(vehicles.values()), "setpoint_gap_max_ms"),
        "cpu_fraction": _load(vehicles, "cpu_fraction"),
        "memory_mb": _load(vehicles, "memory_mb"),
        "dropped": _total(vehicles),
        "events": {level: sum(figures["events"][level] for figures in vehicles.values()) for level in _LEVELS},
        "errors": _errors(run),
        "recordings": _recordings(run),
        "findings": [as_json(finding) for finding in examine_run(run, ANALYSERS)],
        "vehicles": vehicles,
    }
    return summary | {"verdict": verdict_of(summary).level, "headline": one_line(summary)}


_LEVELS = ("info", "warning", "error")


def write_summary(run: Path) -> Path:
    """Write `summary.json` into the run folder; InputError if it holds no readable recording."""
    loaded = load_run([run])
    return save_summary(loaded, summarise(loaded))


def save_summary(run: Run, summary: Summary) -> Path:
    """Write the summary where it belongs; whole or not at all."""
    path = run.output("summary.json")
    write_whole(path, orjson.dumps(summary, option=orjson.OPT_INDENT_2 | orjson.OPT_SERIALIZE_NUMPY) + b"\n")
    return path


def write_whole(path: Path, content: bytes) -> None:
    """Replace `path` by `content` in one step."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        temporary.write_bytes(content)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def _world(run: Run) -> World | None:
    """The obstacles that the mission names; None if it names none: then the world is not known."""
    if run.mission is None or not (run.mission.obstacles.cylinders or run.mission.obstacles.boxes):
        return None
    return World(run.mission.obstacles)


def _mission_name(run: Run) -> str | None:
    if run.mission is not None:
        return run.mission.name
    return next((name for recording in run.recordings if (name := recording.metadata.get("run", {}).get("mission"))), None)


def _seed(run: Run) -> int | None:
    told = [recording.metadata.get("run", {}).get("seed", "") for recording in run.recordings]
    return next((int(text) for text in told if text.lstrip("-").isdigit()), None)


def _separation_required_m(run: Run) -> float | None:
    """The largest separation that a pursuer's profile asks for."""
    return max((v.profile.safety.separation_min_m for v in pursuers_of(run) if v.profile is not None), default=None)


def _clearance_wanted_m(run: Run) -> float | None:
    """The largest safety margin of a pursuer's profile."""
    return max((v.profile.limits.safety_margin_m for v in pursuers_of(run) if v.profile is not None), default=None)


def _errors(run: Run) -> list[dict[str, Any]]:
    """The first error event of each vehicle, in the order of their times; `t_s` is fleet time."""
    found = []
    for vehicle in run.vehicles:
        events = vehicle.recording.topic("/event")
        for t_s, event in zip(events.t_s.tolist(), events.messages, strict=True):
            if event.get("level") == "error":
                found.append({"t_s": t_s, "vehicle": vehicle.name, "name": event.get("name"), "text": event.get("text")})
                break
    return sorted(found, key=lambda error: float(error["t_s"]))


def _recordings(run: Run) -> list[dict[str, Any]]:
    readable = [{"file": r.path.name, "complete": r.complete, "error": r.note or None} for r in run.recordings]
    return readable + [{"file": path.name, "complete": False, "error": reason} for path, reason in run.unreadable]


def _known(sections: list[Summary], name: str) -> list[float]:
    return [section[name] for section in sections if section[name] is not None]


def _mean(sections: list[Summary], name: str) -> float | None:
    values = _known(sections, name)
    return sum(values) / len(values) if values else None


def _least(sections: list[Summary], name: str) -> float | None:
    return min(_known(sections, name), default=None)


def _greatest(sections: list[Summary], name: str) -> float | None:
    return max(_known(sections, name), default=None)


def _load(vehicles: dict[str, Summary], name: str) -> dict[str, float | None]:
    """Mean over the vehicle processes, and the greatest of any of them."""
    sections = [figures[name] for figures in vehicles.values()]
    return {"mean": _mean(sections, "mean"), "max": _greatest(sections, "max")}


def _total(vehicles: dict[str, Summary]) -> int | None:
    """Sum over the vehicles; null if one of them cannot tell."""
    counts = [figures["dropped"] for figures in vehicles.values()]
    return None if None in counts else sum(counts)

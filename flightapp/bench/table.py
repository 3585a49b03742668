"""The result of a bench run for a person."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.table import Table

NOTE = """\
x: how many times faster, by median CPU time. NumPy: the same work in plain NumPy as one would first write it; the fine step
includes all the rest of a decision, its reference does not. ORCA: pyrvo's decision from such an observation; ORCA weighs
velocities only, without game, memory or braking arcs. SDK: the RealSense SDK's decimation by 2 and point cloud of such a frame,
which finds no obstacles yet."""


def print_bench(result: dict[str, Any]) -> None:
    """Print `result` of `run_bench` as a table, times in milliseconds."""
    about = result["machine"]
    loads = ", ".join(f"{load:.2f}" for load in about["load_average"])
    console = Console(soft_wrap=False, width=None if Console().is_terminal else 180)
    console.print(f"{about['cpu']}, {about['cores']} cores, load average {loads}, Python {about['python']}", highlight=False)
    console.print(_times(result))
    console.print(NOTE, highlight=False)
    console.print(_simulator(result["simulator"]), highlight=False)
    console.print(_frame_rate(result["frame_rate"]), highlight=False)
    console.print(_frame_memory(result["frame_memory"]), highlight=False)
    console.print(_memory(result["memory"]), highlight=False)


def _times(result: dict[str, Any]) -> Table:
    table = Table(title="Times in ms; the aim is for the 99th percentile")
    table.add_column("what", no_wrap=True)
    for heading in ("runs", "wall p50", "p99", "max", "CPU p50", "p99", "max", "aim", "verdict", "x NumPy", "x ORCA", "x SDK"):
        table.add_column(heading, justify="right")
    for one in result["measurements"]:
        times = [f"{one[kind][name]:.3f}" for kind in ("wall_ms", "cpu_ms") for name in ("p50", "p99", "max")]
        aim = "" if one["aim_ms"] is None else f"{one['aim_ms']:g}"
        ratios = ["" if one[name] is None else f"{one[name]:.3g}" for name in ("faster_by", "orca_ratio", "sdk_ratio")]
        table.add_row(one["name"], str(one["repetitions"]), *times, aim, one["verdict"], *ratios)
    for one in result["not_measured"]:
        table.add_row(one["name"], "none", *[""] * 7, "not measured")
    table.caption = "\n".join(f"{one['name']}: {one['why']}" for one in result["not_measured"]) or None
    return table


def _simulator(found: dict[str, Any]) -> str:
    rate, cpu_rate = found["simulated_s_per_s"], found["simulated_s_per_cpu_s"]
    return (
        f"Fast simulator, {found['scenario']}, {found['pursuers']} x {found['planner']}, one core: {rate:.0f} simulated s per s "
        f"({cpu_rate:.0f} per CPU s) over {found['episodes']} episodes, aim {found['aim']:g}: {found['verdict']}"
    )


def _frame_rate(found: dict[str, Any]) -> str:
    rate, cpu_rate = found["frames_per_s"], found["frames_per_cpu_s"]
    return (
        f"Perception without a pause, one core: {rate:.0f} frames per s ({cpu_rate:.0f} per CPU s) "
        f"over {found['frames']} frames, aim {found['aim']:g}: {found['verdict']}"
    )


def _frame_memory(found: dict[str, Any]) -> str:
    return (
        f"Memory over {found['frames']} depth frames: {_resident(found)}, {found['slope_bytes_per_frame']:.3f} bytes a frame, "
        f"{found['hour_mib']:.2f} MiB in an hour at 30 Hz: {found['verdict']}"
    )


def _memory(found: dict[str, Any]) -> str:
    modes = ", ".join(f"{mode} {count}" for mode, count in sorted(found["modes"].items()))
    return (
        f"Memory over {found['steps']} decisions ({modes}): {_resident(found)}, "
        f"{found['slope_bytes_per_step']:.3f} bytes a decision: {found['verdict']}"
    )


def _resident(found: dict[str, Any]) -> str:
    before, warm, after = (f"{found[name]:.2f} MiB" for name in ("before_mib", "warm_mib", "after_mib"))
    return f"{before} before, {warm} after the first tenth, {after} at the end"

"""The measurement as tables on the terminal."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.table import Table


def print_perception(result: dict[str, Any]) -> None:
    """Print `result` of `run_perception_truth`."""
    console = Console(width=None if Console().is_terminal else 150)
    about = result["machine"]
    console.print(
        f"{about['cpu']}, {about['cores']} cores; {result['frames']} frames in {result['wall_s']:.0f} s, seed {result['seed']}"
        f"{', quick' if result['quick'] else ''}",
        highlight=False,
    )
    console.print(_detection(result["detection"], "Found, % of frames (held after half a second) by width and distance"))
    console.print(_detection(result["branch"], "Horizontal branch, 4 cm thick, 1 m long"))
    console.print(_conditions(result["conditions"]))
    console.print(_false_discs(result["false_discs"]))
    console.print(_position(result["position"]))
    console.print(_moving(result["moving"]))
    console.print(_aims(result["aims"]))
    _print_false_free(console, result["false_free"])
    needless = result["sectors"]["inside_reported_unseen"]
    if needless is not None:
        console.print(f"Of the bearings wholly in the picture {100 * needless:.2f} % were reported unseen.", highlight=False)
    if result["picture"]:
        console.print(f"picture: {result['picture']}", highlight=False)


def _detection(cells: list[dict[str, Any]], title: str) -> Table:
    distances = sorted({cell["distance_m"] for cell in cells})
    table = Table(title=title)
    table.add_column("width", justify="right")
    for distance in distances:
        table.add_column(f"{distance:g} m", justify="right")
    for width in sorted({cell["width_m"] for cell in cells}):
        rates = {cell["distance_m"]: cell for cell in cells if cell["width_m"] == width}
        table.add_row(f"{100 * width:g} cm", *(_cell(rates.get(distance)) for distance in distances))
    return table


def _cell(cell: dict[str, Any] | None) -> str:
    return "" if cell is None else f"{100 * cell['frame']['rate']:.0f} ({100 * cell['half_second']['rate']:.0f})"


def _conditions(rows: list[dict[str, Any]]) -> Table:
    table = Table(title="Under other conditions; found in % of frames with 95 % interval, at 3, 5 and 7 m or on the approach")
    table.add_column("condition", no_wrap=True)
    for width in (one["width_m"] for one in rows[0]["widths"]) if rows else ():
        table.add_column(f"{100 * width:g} cm", justify="right")
    for heading in ("surface p50", "p95 m", "in free sectors", "while settling", "false discs/min", "static moves"):
        table.add_column(heading, justify="right")
    for row in rows:
        rates = [_interval(one["frame"]) for one in row["widths"]]
        free = row["false_free"]
        table.add_row(
            row["name"],
            *rates,
            *(_number(row["surface_m"][name], 2) for name in ("p50", "p95")),
            str(free["frames"]),
            str(free["frames_settling"]),
            _number(row["false_discs_per_min"], 1),
            f"{100 * row['moves_wrongly']['rate']:.1f} %",
        )
    return table


def _false_discs(rows: list[dict[str, Any]]) -> Table:
    table = Table(title="Discs where there is nothing within range")
    for heading in ("scene", "minutes", "false discs", "a minute"):
        table.add_column(heading, justify="left" if heading == "scene" else "right")
    for row in rows:
        table.add_row(row["name"], f"{row['minutes']:.2f}", str(row["discs"]), _number(row["per_minute"], 1))
    return table


def _position(rows: list[dict[str, Any]]) -> Table:
    table = Table(title="Errors in m, p50 / p95, level and hovering")
    for heading in ("distance", "visible surface", "centre", "radius"):
        table.add_column(heading, justify="right")
    for row in rows:
        errors = [row[name] for name in ("surface_error_m", "centre_error_m", "radius_error_m")]
        table.add_row(
            f"{row['from_m']:g}-{row['to_m']:g} m", *(f"{_number(e['p50'], 2)} / {_number(e['p95'], 2)}" for e in errors)
        )
    return table


def _moving(rows: list[dict[str, Any]]) -> Table:
    table = Table(title="A ball of 70 cm that crosses the view")
    for heading in ("speed", "found %", "velocity error p50 / p95 m/s", "ghosts/min"):
        table.add_column(heading, justify="right")
    for row in rows:
        error = row["velocity_error_m_s"]
        table.add_row(
            f"{row['speed_m_s']:g} m/s",
            _interval(row["frame"]),
            f"{_number(error['p50'], 2)} / {_number(error['p95'], 2)}",
            _number(row["ghosts_per_min"], 1),
        )
    return table


def _aims(rows: list[dict[str, Any]]) -> Table:
    table = Table(title="Aims")
    for heading in ("what", "measured", "aim", "verdict"):
        table.add_column(heading, justify="left" if heading in ("what", "verdict") else "right")
    for row in rows:
        sign = ">=" if row["at_least"] else "<="
        table.add_row(
            row["name"], "" if row["value"] is None else f"{row['value']:.3g}", f"{sign} {row['aim']:g}", row["verdict"]
        )
    return table


def _print_false_free(console: Console, found: dict[str, Any]) -> None:
    console.print(
        f"Solid things (at least 5 cm, within 8 m) in sectors reported free: {found['frames']} frames in "
        f"{found['minutes']:.2f} min, and {found['frames_settling']} in the first 0.2 s",
        highlight=False,
    )
    for one in found["list"]:
        where = f"{100 * one['width_m']:g} cm at {one['distance_m']:g} m, frame {one['frame']}, seed {one['seed']}"
        console.print(f"  {one['condition']}: {where}", highlight=False)


def _interval(rate: dict[str, Any]) -> str:
    if rate["rate"] is None:
        return ""
    return f"{100 * rate['rate']:.0f} [{100 * rate['low']:.0f}, {100 * rate['high']:.0f}]"


def _number(value: float | None, digits: int) -> str:
    return "" if value is None else f"{value:.{digits}f}"

"""What the study measured, beside what the source prints: rows for terminals, files and documents."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields

from flightapp.sim.control_study.flown import SPACING_M, Figures, Flown, FlownScene
from flightapp.sim.control_study.printed_tables import FIGURES_16_TO_18, NAMES, TABLE_1, TABLE_2

STEADY_MAX_M = 0.4
SUCCESS_MIN = 0.98
OURS, SOURCE = "hybrid tuned", "hybrid printed"


@dataclass(frozen=True, slots=True)
class Row:
    """One method on one plant in one setting: the extremes of clearance and of pairs, and `mean`s over the scenes."""

    setting: str
    plant: str
    method: str
    scenes: int
    success_share: float
    error_steady_std_m: float
    clearance_min_m: float
    pair_min_m: float
    pair_min_mean_m: float
    emergencies: int
    mean: Figures

    def as_json(self) -> dict[str, object]:
        told = asdict(self)
        return {**told, **told.pop("mean")}


def rows_of(scenes: Sequence[FlownScene]) -> list[Row]:
    """In the order in which they were flown."""
    groups: dict[tuple[str, str, str], list[Flown]] = {}
    for scene in scenes:
        for one in scene.flights:
            groups.setdefault((one.setting, one.plant, one.method), []).append(one)
    return [_row(flown) for flown in groups.values()]


def _row(flown: list[Flown]) -> Row:
    first = flown[0]
    means = {
        field.name: round(statistics.fmean(getattr(one.figures, field.name) for one in flown), 3) for field in fields(Figures)
    }
    return Row(
        setting=first.setting,
        plant=first.plant,
        method=first.method,
        scenes=len(flown),
        success_share=round(statistics.fmean(one.succeeded for one in flown), 3),
        error_steady_std_m=round(statistics.pstdev(one.figures.error_steady_m for one in flown), 3),
        clearance_min_m=round(min(one.clearance_min_m for one in flown), 3),
        pair_min_m=round(min(one.pair_min_m for one in flown), 3),
        pair_min_mean_m=round(statistics.fmean(one.pair_min_m for one in flown), 3),
        emergencies=sum(one.emergencies for one in flown),
        mean=Figures(**means),
    )


@dataclass(frozen=True, slots=True)
class Acceptance:
    """Section 5 of the specification, judged on the plant with lag: `failed` names every scene that broke something."""

    scenes: int
    unplanned: int
    failed: tuple[str, ...]

    @property
    def share(self) -> float:
        return 1.0 - len(self.failed) / self.scenes if self.scenes else 0.0

    @property
    def accepted(self) -> bool:
        return self.share >= SUCCESS_MIN

    @property
    def sentence(self) -> str:
        return (
            f"acceptance ({OURS} on the plant with lag): {self.scenes - len(self.failed)} of {self.scenes} scenes without "
            f"contact, arrived, every pair {SPACING_M:g} m apart, steady error below {STEADY_MAX_M:g} m, no worse than {SOURCE}"
            f"{f'; {self.unplanned} had no path' if self.unplanned else ''}: {'met' if self.accepted else 'not met'}"
        )


def acceptance(scenes: Sequence[FlownScene], plant: str) -> Acceptance:
    """Of all `scenes`; those without a path count on their own."""
    failed = []
    flown = [scene for scene in scenes if scene.flights]
    for scene in flown:
        by_method = {one.method: one for one in scene.flights if one.plant == plant}
        ours, source = by_method.get(OURS), by_method.get(SOURCE)
        if ours is None:
            continue
        steady_m = ours.figures.error_steady_m
        found = [
            text
            for broken, text in (
                (not ours.succeeded, "no success"),
                (ours.pair_min_m < SPACING_M, f"pair {ours.pair_min_m:.2f} m"),
                (steady_m >= STEADY_MAX_M, f"steady error {steady_m:.2f} m"),
                (source is not None and steady_m > source.figures.error_steady_m, f"worse than {SOURCE}"),
            )
            if broken
        ]
        if found:
            failed.append(f"{scene.setting}, seed {scene.seed}: {', '.join(found)}")
    return Acceptance(len(flown), len(scenes) - len(flown), tuple(failed))


HEADINGS_1 = ("setting", "plant", "method", "success %", "steady error m", "pair min m", "source: %", "source: m", "source: m ")
HEADINGS_2 = (
    "plant",
    "method",
    "tracking",
    "limited %",
    "mean pair",
    "nearest, least",
    "formation",
    "clearance m",
    "emergencies",
)

HEADINGS_3 = (
    "plant",
    "method",
    "x, y: largest later",
    "z: largest in 5 s, later",
    "|e|: peak, later",
    "|s|: peak, later",
    "V: start, at 5 s",
)


def cells_1(row: Row) -> tuple[str, ...]:
    """Table 1: means over scenes, with the standard deviation of the steady error."""
    printed = _printed(TABLE_1.get(row.setting), row.method)
    steady = f"{row.mean.error_steady_m:.2f} +- {row.error_steady_std_m:.2f}"
    own = (row.setting, row.plant, row.method, f"{100 * row.success_share:.1f}", steady, f"{row.pair_min_mean_m:.2f}")
    return (*own, *(("-",) * 3 if printed is None else tuple(f"{value:g}" for value in printed)))


def cells_2(row: Row) -> tuple[str, ...]:
    """Table 2: tracking and formation as mean, steady or max, std; spacing as mean, min, max, std of the mean pair."""
    mean = row.mean
    return (
        row.plant,
        row.method,
        f"{mean.error_mean_m:.2f}, {mean.error_steady_m:.2f}, {mean.error_max_m:.1f}, {mean.error_std_m:.2f}",
        f"{100 * mean.limited_share:.0f}",
        f"{mean.pair_mean_m:.1f}, {mean.pair_mean_min_m:.1f}, {mean.pair_mean_max_m:.1f}, {mean.pair_std_m:.1f}",
        f"{mean.nearest_mean_m:.2f}, {row.pair_min_m:.2f}",
        f"{mean.formation_mean_m:.2f}, {mean.formation_max_m:.1f}, {mean.formation_std_m:.2f}",
        f"{row.clearance_min_m:.2f}",
        str(row.emergencies),
    )


def cells_3(row: Row) -> tuple[str, ...]:
    """Figures 16 to 18: the leader's errors, the printed sliding variable, the printed Lyapunov function."""
    mean = row.mean
    return (
        row.plant,
        row.method,
        f"{mean.north_later_m:.2f}, {mean.east_later_m:.2f}",
        f"{mean.down_peak_m:.2f}, {mean.down_later_m:.2f}",
        f"{mean.leader_peak_m:.2f}, {mean.leader_later_m:.2f}",
        f"{mean.sliding_peak_m_s:.0f}, {mean.sliding_later_m_s:.1f}",
        f"{mean.lyapunov_start:.2g}, {mean.lyapunov_5_s:.2g}",
    )


def _printed(table: tuple[tuple[float, ...], ...] | None, method: str) -> tuple[float, ...] | None:
    name = method.split()[0]
    return None if table is None or name not in NAMES else table[NAMES.index(name)]


def as_markdown(rows: Sequence[Row], verdict: str) -> str:
    """The tables, what the source prints, and the verdict."""
    first = rows[0].setting
    parts = ["## Table 1", _markdown(HEADINGS_1, [cells_1(row) for row in rows])]
    parts += [f"## Table 2 ({first})", _markdown(HEADINGS_2, [cells_2(row) for row in rows if row.setting == first])]
    parts += [f"## Figures 16 to 18 ({first})", _markdown(HEADINGS_3, [cells_3(row) for row in rows if row.setting == first])]
    parts += ["Printed for its hybrid: " + FIGURES_16_TO_18]
    printed = [
        (metric, *(", ".join(f"{value:g}" for value in values) for values in by_name)) for metric, by_name in TABLE_2.items()
    ]
    parts += ["## Table 2 as printed", _markdown(("m", *NAMES), printed), verdict]
    return "\n\n".join(parts) + "\n"


def _markdown(headings: Sequence[str], lines: Sequence[Sequence[str]]) -> str:
    return "\n".join(f"| {' | '.join(line)} |" for line in (headings, ("---",) * len(headings), *lines))

"""Which runs of a campaign are drawn, and the files of their pictures. Drawn runs are flown again: that is exact."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from flightapp.analysis.campaign.pictures.convergence import convergence_picture
from flightapp.analysis.campaign.pictures.modes import modes_picture
from flightapp.analysis.campaign.pictures.paths import distance_picture, paths_picture
from flightapp.analysis.campaign.seeds import parse_seeds
from flightapp.analysis.campaign.trace import trace
from flightapp.core.errors import InputError
from flightapp.sim.batch.result import RunResult
from flightapp.sim.batch.scenario import Scenario

DRAWN_MAX = 50
TOGETHER = 20


@dataclass(frozen=True, slots=True)
class Drawing:
    """Which runs. `seeds`: drawn with all planners; `failed`: so many failed runs of the last planner are drawn, too.

    together: seeds over which it is drawn how each planner closes in.
    """

    seeds: tuple[int, ...]
    failed: int
    together: tuple[int, ...] = ()

    def files(
        self, scenario: Scenario, planners: Sequence[str], results: Sequence[RunResult], parameters: Mapping[str, object] | None
    ) -> Iterator[tuple[str, bytes]]:
        """(name, PNG): of each seed paths and distances of all planners, and modes of the last; all closing in; failed runs."""
        last = planners[-1]
        for seed in self.seeds:
            traces = [trace(scenario, planner, seed, parameters) for planner in planners]
            yield f"paths-{seed}.png", paths_picture(traces)
            yield f"distance-{seed}.png", distance_picture(traces)
            yield f"modes-{last}-{seed}.png", modes_picture(traces[-1])
        if len(self.together) > 1:
            runs = [[trace(scenario, planner, seed, parameters) for seed in self.together] for planner in planners]
            yield "convergence.png", convergence_picture(runs)
        failed = [result.seed for result in results if result.planner == last and result.outcome != "captured"]
        for seed in failed[: self.failed]:
            yield f"failed-{last}-{seed}.png", modes_picture(trace(scenario, last, seed, parameters))


def parse_drawing(text: str | None, seeds: tuple[int, ...]) -> Drawing:
    """What `text` asks for: `none`, `failed:N`, seeds; else the first of `seeds`, the first 20 together, three failed runs."""
    if text is None:
        return Drawing(seeds[:1], 3, seeds[:TOGETHER])
    if text == "none":
        return Drawing((), 0)
    failed = re.fullmatch(r"failed:(\d{1,9})", text)
    try:
        drawing = Drawing((), int(failed[1])) if failed is not None else Drawing(parse_seeds(text), 0)
    except InputError:
        raise InputError(f"--draw {text}: write none, failed:3 or seeds (0,17)") from None
    if drawing.failed + len(drawing.seeds) > DRAWN_MAX:
        raise InputError(f"--draw {text}: more than {DRAWN_MAX} runs; name fewer")
    return drawing

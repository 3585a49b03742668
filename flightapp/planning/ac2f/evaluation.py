"""What the search of the dynamic window found, as plain values: in short for every step, and in full on request."""

from __future__ import annotations

from flightapp.planning.ac2f.fine import TERMS, Workspace
from flightapp.planning.ac2f.records import Record

VERDICTS = ("admissible", "clearance/collision", "clearance/braking")
"""The critic and why it rejects a candidate, by the verdict of the sweep."""


def summary(action: Record) -> dict[str, object]:
    """The scores of the best arc with their weights, or, where none is admissible, how many each reason rejects."""
    found = action[0]
    if found["best"] < 0:
        tally = {VERDICTS[1]: int(found["collisions"]), VERDICTS[2]: int(found["brakings"])}
        return {"no_admissible": True, "tally": tally}
    weights = _weights(action)
    best: dict[str, object] = {term: float(found[term]) for term in TERMS if term != "memory" or weights["memory"] != 0.0}
    return {"best": {**best, "weights": weights}}


def evaluation(action: Record, workspace: Workspace) -> dict[str, object]:
    """The index of the best candidate (None: none is admissible), the weights, and a row for every candidate of the window.

    A row has speed_m_s, turn_rad_s, verdict, and the raw score of each critic, which counts for admissible candidates only.
    """
    best = int(action[0]["best"])
    columns = [workspace.speeds_m_s.tolist(), workspace.turns_rad_s.tolist(), *workspace.scores.tolist()]
    names = ("speed_m_s", "turn_rad_s", *TERMS)
    verdicts = [VERDICTS[verdict] for verdict in workspace.verdicts.tolist()]
    rows = [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]
    candidates = [{**row, "verdict": verdict} for row, verdict in zip(rows, verdicts, strict=True)]
    return {"best": best if best >= 0 else None, "weights": _weights(action), "candidates": candidates}


def _weights(action: Record) -> dict[str, float]:
    return {term: float(action[0]["weight_" + term]) for term in TERMS}

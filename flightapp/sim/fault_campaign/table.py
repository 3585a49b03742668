"""The fault campaign on a terminal."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from rich.console import Console
from rich.table import Table

from flightapp.sim.fault_campaign.campaign import FinishedFaults
from flightapp.sim.fault_campaign.flight import Verdict
from flightapp.sim.fault_campaign.kinds import KINDS

FELT = ("felt", "not felt", "not begun")
SHOWN_MAX = 40


def print_fault_campaign(finished: FinishedFaults) -> None:
    console = Console()
    console.print(_by_kind(finished.verdicts))
    console.print(_by_outcome(finished.verdicts))
    violations = [violation for verdict in finished.verdicts for violation in verdict.violations]
    for violation in violations[:SHOWN_MAX]:
        at = "" if violation.time_s is None else f" at {violation.time_s:.2f} s"
        who = f" {violation.vehicle}" if violation.vehicle else ""
        console.print(f"seed {violation.seed}{who}{at}: {violation.invariant}: {violation.text}", markup=False, soft_wrap=True)
    if len(violations) > SHOWN_MAX:
        console.print(f"and {len(violations) - SHOWN_MAX} more in missions.json")
    ended = "" if finished.complete else ", ended early"
    console.print(
        f"{len(finished.verdicts)} missions in {finished.seconds:.0f} s{ended}, {len(violations)} violations", markup=False
    )
    console.print(f"files: {finished.folder}", markup=False, soft_wrap=True)


def _by_kind(verdicts: Sequence[Verdict]) -> Table:
    """How often each kind was injected, what of it was felt, and in how many missions with it something was violated."""
    table = Table(title="faults")
    for heading in ("fault", *FELT, "missions with a violation"):
        table.add_column(heading, justify="left" if heading == "fault" else "right")
    counts = Counter((kind, found) for verdict in verdicts for kind, _, found in verdict.injections)
    violating = Counter(
        kind for verdict in verdicts if verdict.violations for kind in {kind for kind, _, _ in verdict.injections}
    )
    for kind in KINDS:
        if any(counts[kind, found] for found in FELT):
            table.add_row(kind, *(str(counts[kind, found]) for found in FELT), str(violating[kind]))
    return table


def _by_outcome(verdicts: Sequence[Verdict]) -> Table:
    table = Table(title="vehicles by outcome")
    table.add_column("outcome")
    table.add_column("vehicles", justify="right")
    outcomes = Counter(outcome or "process killed" for verdict in verdicts for _, outcome in verdict.outcomes)
    for outcome, count in sorted(outcomes.items()):
        table.add_row(outcome, str(count))
    return table

"""The exhaustive model: nothing breaks in the real core, and every broken rule is found."""

from __future__ import annotations

import pytest

from flightapp.fleet.election.core import Election
from flightapp.fleet.election.model import TIMING, Model, RuleBrokenError, drifting, main
from tests.fleet.election import broken

DRIFT = TIMING.clock_drift_max


@pytest.mark.parametrize("rates", drifting(3, DRIFT)[:2])
def test_no_schedule_of_three_members_breaks_a_rule_and_all_heal(rates: tuple[float, ...]) -> None:
    explored = Model(rates).explore(depth=3, crashes=1, situations_max=10**6)
    assert explored.depth == 3
    assert explored.schedules > 4_000
    assert explored.healed > 40


@pytest.mark.parametrize(
    ("member", "start", "depth", "crashes"),
    [
        (broken.VotesTwice, "rivals", 7, 0),
        (broken.NeedsNoMajority, "all seeking", 3, 0),
        (broken.BreaksPromises, "one parted", 5, 0),
        (broken.ForgetsItsPromiseOnRestart, "one parted", 6, 1),
        (broken.ForgetsItsTermOnRestart, "settled", 3, 1),
        (broken.LeadsOnWithoutAnswers, "leader late", 5, 0),
        (broken.ForgetsDrift, "leader late", 5, 0),
        (broken.ListensToOldTerms, "leader late", 4, 0),
    ],
)
def test_a_member_that_breaks_a_rule_is_found(member: type[Election], start: str, depth: int, crashes: int) -> None:
    clocks = drifting(3, DRIFT)[1 if member is broken.ForgetsDrift else 0]
    with pytest.raises(RuleBrokenError, match=f"from '{start}'"):
        Model(clocks, member, heard_late=1).explore(depth, crashes, 10**6, starts=(start,), heals=False)


def test_the_command_tells_what_it_has_seen(capsys: pytest.CaptureFixture[str]) -> None:
    main(["--nodes", "2", "--depth", "2"])
    told = capsys.readouterr().out
    assert "2 nodes, depth 2" in told
    assert "no rule broken" in told

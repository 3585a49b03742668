"""How a pursuit ends when vehicles say different things."""

from flightapp.runtime.outcome import Outcome, outcome_of_team


def test_a_capture_told_by_one_vehicle_counts_for_all_and_an_abort_does_not() -> None:
    assert outcome_of_team([None, "aborted", "captured"]) is Outcome.CAPTURED
    assert outcome_of_team(["aborted", "fault", None]) is None
    assert outcome_of_team([]) is None

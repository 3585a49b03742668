"""What must not be forgotten, what must not be believed, and what travels."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from flightapp.core.errors import InputError
from flightapp.fleet.election.beacon import Beacon, Role
from flightapp.fleet.election.memory import Memory, MemoryFile
from flightapp.fleet.election.timing import Timing
from flightapp.fleet.messages.codec import Header, MalformedPayloadError, decode, encode
from flightapp.fleet.messages.election import ELECTION
from flightapp.runtime.leadership import memory_path

HEADER = Header("p2", 7, 1_000.0)


def test_term_and_vote_outlast_the_process_and_nothing_else_is_left_in_the_folder(tmp_path: Path) -> None:
    path = memory_path(tmp_path / "20260601-101500-demo", tmp_path, "demo", "p1")
    assert MemoryFile(path).load() == Memory()
    MemoryFile(path).store(Memory(3, "p2"))
    MemoryFile(path).store(Memory(4, None))
    assert MemoryFile(memory_path(tmp_path / "20260601-101700-demo", tmp_path, "demo", "p1")).load() == Memory(4, None)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("content", ["", "{", '{"term": "many"}', '{"term": -1, "vote": null}'])
def test_a_file_that_holds_something_else_is_named(tmp_path: Path, content: str) -> None:
    path = tmp_path / "election.json"
    path.write_text(content)
    with pytest.raises(InputError, match="election"):
        MemoryFile(path).load()


def test_a_lease_that_could_outlast_a_promise_is_refused() -> None:
    with pytest.raises(ValueError, match="make the lease shorter"):
        Timing(lease_s=0.65, timeout_min_s=0.7, clock_drift_max=0.05)


def test_a_beacon_arrives_as_it_was_sent_whatever_the_clocks_differ() -> None:
    beacon = Beacon(1_000.25, 12, Role.FOLLOWER, (("p1", -3.5), ("p3", 1.7e9)))
    assert decode(ELECTION, encode(ELECTION, beacon, HEADER), clock_ahead_s=30.0)[0] == beacon


@pytest.mark.parametrize("stamp_s", [math.nan, math.inf])
def test_a_stamp_that_is_no_time_is_refused(stamp_s: float) -> None:
    for beacon in (Beacon(stamp_s, 1, Role.LEADER), Beacon(1.0, 1, Role.FOLLOWER, (("p1", stamp_s),))):
        with pytest.raises(MalformedPayloadError, match="not finite"):
            decode(ELECTION, encode(ELECTION, beacon, HEADER))

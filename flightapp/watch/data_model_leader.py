"""Who leads the pursuers, from their election beacons; see `flightapp.fleet.election`."""

from __future__ import annotations

from dataclasses import dataclass

from flightapp.fleet.election.beacon import Role
from flightapp.fleet.election.timing import Timing
from flightapp.watch.data_model_heard import Heard

BEACON_AGE_MAX_S = Timing().timeout_max_s
"""After so long a silence of the leader its followers have sought another."""


@dataclass(frozen=True, slots=True)
class Leadership:
    """`leader` None: nobody leads, or nobody who does is heard."""

    leader: str | None = None
    term: int = 0
    """Newest that was heard of."""
    followers: tuple[str, ...] = ()
    claimants: tuple[str, ...] = ()
    """All who say that they lead, in whatever term: more than one only while a network is cut in two."""
    is_voted: bool = False
    """Whether anybody who takes part in elections is heard."""


def leadership_of(heard: Heard) -> Leadership:
    """What the beacons that are still young come to; of several leaders the one of the newest term leads."""
    fresh = {name: beacon for name, (sent_s, beacon) in heard.beacons.items() if heard.now_s - sent_s <= BEACON_AGE_MAX_S}
    claimants = sorted((name for name, beacon in fresh.items() if beacon.role is Role.LEADER), key=lambda one: -fresh[one].term)
    leader = claimants[0] if claimants else None
    followers = [
        name
        for name, beacon in fresh.items()
        if beacon.role is Role.FOLLOWER and leader in {backed for backed, _ in beacon.backs}
    ]
    term = max((beacon.term for _, beacon in heard.beacons.values()), default=0)
    return Leadership(leader, term, tuple(sorted(followers)), tuple(claimants), bool(fresh))

"""What a vehicle says of itself, to whom and when: states by `state_rates`, the election's beacons by what they are for."""

from __future__ import annotations

import math
from dataclasses import replace

from flightapp.fleet.election.beacon import Beacon, Role
from flightapp.fleet.messages.election import ELECTION
from flightapp.fleet.messages.intent import Intent
from flightapp.fleet.messages.state import State
from flightapp.fleet.post import Post
from flightapp.fleet.shared_state import SharedState
from flightapp.fleet.state_rates import NEAR_EVERY, Mate, StateRates
from flightapp.fleet.team import Team

ALL_PERIOD_S = 0.8
"""Between a follower's beacons to everybody: for who looks on, and who has missed a term."""


class StateTelling:
    """Sends the own state and intent to those who are to have them now."""

    def __init__(self, team: Team, rates: StateRates) -> None:
        self._team, self._rates = team, rates
        self._told_all_s = self._told_near_s = -math.inf

    def tell(self, state: State, intent: Intent, now_s: float) -> None:
        """To be called once a state period."""
        rates, others = self._rates, self._team.peers
        own = Mate(state.position_ned_m, state.velocity_ned_m_s, max(0.0, now_s - state.t_s))
        now = rates.at(now_s, own, {name: _mate(peer.state, now_s) for name, peer in others.items()})
        to_all = len(now.full) == len(others)
        self._team.post.holds = not to_all
        if to_all or now_s - self._told_all_s >= rates.slow_period_s - 0.5 * rates.period_s:
            self._told_all_s = now_s
            due_s = rates.period_s if to_all else rates.slow_period_s
            self._team.publish(replace(state, due_s=due_s), intent, now_s)
            self._told_near_s = now_s
        elif now_s - self._told_near_s >= (NEAR_EVERY - 0.5) * rates.period_s:
            self._told_near_s = now_s
            self._team.publish(replace(state, due_s=NEAR_EVERY * rates.period_s), intent, now_s, now.full | now.half)
        else:
            self._team.publish(replace(state, due_s=rates.period_s), intent, now_s, now.full)


class BeaconTelling:
    """Sends what the election says, where it matters: of n members n - 1 need not hear what a follower answers its leader."""

    def __init__(self, post: Post) -> None:
        self._outlet = post.outlet(ELECTION, addressed=True)
        self._told_all_s = -math.inf

    def tell(self, beacon: Beacon, now_s: float) -> None:
        """A follower's answer is for those alone whom it backs, now and then for everybody; all else concerns everybody."""
        backed = [name for name, _ in beacon.backs]
        if beacon.role is not Role.FOLLOWER or not backed:
            self._outlet.put(beacon, now_s)
            return
        self._outlet.put_to(backed, beacon, now_s)
        if now_s - self._told_all_s >= ALL_PERIOD_S:
            self._told_all_s = now_s
            self._outlet.ride(beacon, now_s)


def _mate(state: SharedState | None, now_s: float) -> Mate | None:
    return None if state is None else Mate(state.position_ned_m, state.velocity_ned_m_s, max(0.0, now_s - state.t_s))

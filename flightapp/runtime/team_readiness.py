"""Whether the others are ready for the pursuit."""

from __future__ import annotations

from flightapp.runtime.rooms import Rooms

PEER_AGE_MAX_S = 1.0


def missing_vehicles(rooms: Rooms, *, begins_early: bool) -> list[str]:
    """Who of the team is not ready, and why. begins_early: whoever is on its ingress joins as soon as one pursues."""
    ready = ("ready", "pursue", "ingress") if begins_early else ("ready", "pursue")
    now_s = rooms.clock.now_s()
    missing = []
    for name, peer in rooms.team.peers.items():
        state = peer.state
        if state is None:
            missing.append(f"{name} (not heard)")
        elif state.mission != rooms.mission_digest:
            missing.append(f"{name} (flies another version of the mission file)")
        elif now_s - state.t_s > PEER_AGE_MAX_S:
            missing.append(f"{name} (silent for {now_s - state.t_s:.0f} s)")
        elif state.phase not in ready:
            missing.append(f"{name} (in phase {state.phase})")
    return missing

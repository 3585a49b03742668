"""The key space of a fleet: `flightapp/<fleet>/<vehicle>/<kind>`, one writer a key.

What is for one of the others alone stands at `flightapp/<fleet>/<vehicle>/<kind>/<receiver>`: the writer is the same.

| kind     | writer, form             | sent                           | what it is                                         |
|----------|--------------------------|--------------------------------|----------------------------------------------------|
| state    | the vehicle, publication | 20 Hz (`state_rate_hz`), see below | motion, phase, outcome                         |
| intent   | the vehicle, publication | on change and 2 Hz             | mode, goal, arrival time, guards, mission's digest |
| sighting | the vehicle, publication | when its camera sees the target | where the target was seen, and how well           |
| discs    | a pursuer, publication   | once a second (`share_discs`)  | obstacles that others may meet, 8 of 12 at most    |
| election | the pursuer, publication | 10 Hz, and when it is asked     | its standing in the election of a leader           |
| plan     | the leader, publication  | 5 Hz                           | who closes in from where, arrival, members         |
| verdict  | the pursuer, publication | 10 Hz while it holds           | its own view that the evader is captured           |
| alive    | the vehicle, liveliness  | while its session lives        | token without content                              |
| clock    | the vehicle, queryable   | asked by others, once a second | fleet time of the vehicle that answers             |
| command  | the vehicle, queryable   | asked by operators             | operator's wish; the reply acknowledges it         |

In a large team mates for whom it does not matter get a quarter of the states: `flightapp.fleet.state_rates`.

All content but that of `alive` and the question of `clock` has the form of `codec`. Vehicle and fleet are names of the mission.
"""

from __future__ import annotations

ROOT = "flightapp"
ALIVE = "alive"
CLOCK = "clock"
COMMAND = "command"


def key(fleet: str, vehicle: str, kind: str) -> str:
    """`*` as vehicle or kind: all of them."""
    return f"{ROOT}/{fleet}/{vehicle}/{kind}"


def key_to(fleet: str, vehicle: str, kind: str, receiver: str) -> str:
    """Of what `vehicle` tells `receiver` alone."""
    return f"{key(fleet, vehicle, kind)}/{receiver}"


def command_key(fleet: str, vehicle: str) -> str:
    """Key on which a vehicle answers operator commands."""
    return key(fleet, vehicle, COMMAND)

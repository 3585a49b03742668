"""When the app answers for where a vehicle flies.

It does, from the first to the last moment, unless before that moment

- a fault was felt that takes the vehicle out of its hands or misleads it about where it is: motors, a GPS that fails or lies,
  telemetry that tells a wrong place, a link over which setpoints do not arrive in time, the death of its process. What the
  vehicle does then is the autopilot's or physics' doing, and a wrong place stays wrong for the way that follows from it;
- a pilot took over. A person who hands the vehicle back does not make the app answer for where they left it.

Faults that the app is told about or can see (late or no telemetry, a silent camera, a refusal, a low battery, planner, network,
clock, disk) excuse nothing. Which fault excuses stands beside each in `kinds`.
"""

from __future__ import annotations

import math

from flightapp.sim.fault_campaign.trace import Trace


def answers_until_s(trace: Trace, vehicle: str) -> float:
    """Until when the app answers for the place of `vehicle`; infinite where nothing excuses it."""
    felt = [one.felt_s for one in trace.injections if one.vehicle == vehicle and one.excuses and one.felt_s is not None]
    taken = [takeover.t_s for takeover in trace.vehicles[vehicle].takeovers]
    return min([*felt, *taken], default=math.inf)

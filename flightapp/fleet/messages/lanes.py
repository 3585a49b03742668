"""Priorities of their own for what must not be overtaken by states.

Zenoh (1.10) counts the packets of each priority and drops a best-effort one that a later one of the same priority has overtaken.
On a link with jitter, kinds that share a priority overtake one another all the time: two namespaces, 50 +- 25 ms and 10 % loss,
lost 26 % of the messages, with gaps of 1 s; with a priority a kind 13 % and 0.5 s. The order of the priorities says nothing: none
of them waits on a link that is not full.
"""

from __future__ import annotations

import zenoh

from flightapp.fleet.messages.codec import Delivery

BEACONS = Delivery(zenoh.Priority.INTERACTIVE_HIGH, zenoh.Reliability.BEST_EFFORT, express=True)
"""Of the election. A leader whose beacons go missing is deposed."""
PLANS = Delivery(zenoh.Priority.INTERACTIVE_LOW, zenoh.Reliability.BEST_EFFORT, express=True)
VERDICTS = Delivery(zenoh.Priority.DATA_HIGH, zenoh.Reliability.BEST_EFFORT, express=True)

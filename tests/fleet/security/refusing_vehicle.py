"""A vehicle as a process that tells what its Zenoh refused: KEYS ENDPOINT; one JSON object of counts on standard error."""

import json
import sys
import time
from collections import Counter
from pathlib import Path

from flightapp.fleet.security.access import Membership
from flightapp.fleet.security.credentials import load_credentials
from flightapp.fleet.security.refusals import ZenohLog, connected_names, refusals
from flightapp.fleet.session import zenoh_config
from tests.fleet.security.members import FLEET, VEHICLES, Vehicle


def main() -> None:
    import zenoh

    keys, endpoint = sys.argv[1:]
    membership = Membership(FLEET, VEHICLES, load_credentials(Path(keys) / "p1"))
    session = zenoh.open(zenoh_config([endpoint], [], membership=membership))
    log, vehicle = ZenohLog(), Vehicle("p1", session)
    total: Counter[str] = Counter()
    sys.stderr.write("ready\n")
    deadline = time.monotonic() + 30.0
    while time.monotonic() < deadline:
        for _ in range(10):
            vehicle.tick()
            time.sleep(0.01)
        found = refusals(log.take(), connected_names(session))
        if found - total:
            total |= found
            sys.stderr.write(json.dumps(total) + "\n")
            sys.stderr.flush()


main()

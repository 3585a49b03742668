"""The process that flies one vehicle: `flightapp fly` starts it under the deadman, in simulation as on the aircraft."""

from __future__ import annotations

import argparse
import asyncio
import logging
import os
import signal
import sys
from collections.abc import Collection
from pathlib import Path

from flightapp.core.errors import FlightError, InputError
from flightapp.core.line_log import LineLog
from flightapp.core.parent_death import signal_on_parent_death
from flightapp.recording.live import ADDRESS, LiveView
from flightapp.runtime.executive import Executive
from flightapp.runtime.heartbeat import Heartbeat
from flightapp.runtime.opening import Wish, open_rooms, running_loop
from flightapp.runtime.outcome import EXIT_STATUS, Outcome
from flightapp.runtime.refusal_watch import watching_refusals

THREAD_SWITCH_S = 0.0005
"""How long the perception thread may keep the interpreter from the control loop."""


async def fly(wish: Wish, waived: Collection[str], heartbeat: Heartbeat) -> Outcome:
    """Fly one vehicle to the end of its mission, whatever that is."""
    async with open_rooms(wish, heartbeat) as opened, watching_refusals(opened.rooms):
        executive = Executive(opened.rooms, waived)
        async with running_loop(opened, executive.on_command) as loop:
            executive.attach(loop)
            for number in (signal.SIGTERM, signal.SIGINT):
                asyncio.get_running_loop().add_signal_handler(number, executive.request_landing, signal.Signals(number).name)
            return await executive.fly()


def main(arguments: list[str] | None = None) -> int:
    """Parse, fly, and turn the outcome into an exit status."""
    parser = argparse.ArgumentParser(prog="python -m flightapp.runtime.vehicle_process", description=__doc__)
    parser.add_argument("--mission", type=Path, required=True)
    parser.add_argument("--profile", type=Path, required=True)
    parser.add_argument("--vehicle", required=True)
    parser.add_argument("--run", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--waive", action="append", default=[])
    parser.add_argument("--heartbeat-fd", type=int, default=None)
    parser.add_argument("--live", type=int, default=None)
    parser.add_argument("--live-address", default=ADDRESS)
    options = parser.parse_args(arguments)
    log = LineLog.install()
    if options.heartbeat_fd is not None:
        signal_on_parent_death(signal.SIGTERM, os.getppid())
    sys.setswitchinterval(THREAD_SWITCH_S)
    heartbeat = Heartbeat(options.heartbeat_fd)
    try:
        live = None if options.live is None else LiveView(options.live, options.live_address)
        wish = Wish(options.mission, options.profile, options.vehicle, options.run, options.seed, live)
        outcome = asyncio.run(fly(wish, options.waive, heartbeat))
    except InputError as error:
        logging.getLogger(options.vehicle).error("%s", error)
        return 2
    except FlightError as error:
        logging.getLogger(options.vehicle).error("%s", error)
        return 3
    except Exception:
        logging.getLogger(options.vehicle).exception("vehicle process")
        return 3
    finally:
        log.close()
    return EXIT_STATUS[outcome]


if __name__ == "__main__":
    sys.exit(main())

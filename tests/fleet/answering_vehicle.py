"""A vehicle that only answers commands, as a process that can be frozen and killed: NAME ENDPOINT OBEYED_FILE."""

import sys
import time
from pathlib import Path

import zenoh

from flightapp.core.clock import SystemClock
from flightapp.fleet.messages.command import Command
from flightapp.fleet.session import zenoh_config
from flightapp.fleet.team import Team

PERIOD_S = 0.04


def main() -> None:
    name, endpoint, file = sys.argv[1:]
    clock = SystemClock()
    session = zenoh.open(zenoh_config([endpoint], []))
    team = Team(session, "hover", name, [], lambda *_: None)

    def accept(command: Command) -> tuple[bool, str]:
        with Path(file).open("a") as obeyed:
            obeyed.write(f"{command.action} {command.identifier} {command.operator}\n")
        return (False, "not possible in phase takeoff") if command.action == "resume" else (True, f"obeys {command.action}")

    sys.stdout.write("ready\n")
    sys.stdout.flush()
    while True:
        team.take_commands(clock.now_s(), accept)
        time.sleep(PERIOD_S)


main()

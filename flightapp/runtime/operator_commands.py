"""Operators' commands: judged by the phase of the mission, answered at once, handed to the failsafes as wishes."""

from __future__ import annotations

from flightapp.fleet.messages.command import Command
from flightapp.runtime.control_loop import ControlLoop
from flightapp.runtime.failsafe_watch import FailsafeWatch
from flightapp.safety.failsafe.table import Condition

WISHED = {
    "rtl": (Condition.OPERATOR_RETURN, "returning"),
    "land": (Condition.OPERATOR_LAND, "landing"),
    "abort": (Condition.OPERATOR_ABORT, "landing"),
}
"""Commands that end the mission, and the answers to them."""


def obey(command: Command, loop: ControlLoop, failsafes: FailsafeWatch) -> tuple[bool, str]:
    """Operator command -> (accepted, text)."""
    who = f"operator {command.operator}" if command.operator else "operator"
    if loop.phase == "done":
        return False, "the mission is over"
    if command.action in WISHED:
        condition, text = WISHED[command.action]
        failsafes.want(condition, f"{command.action} from {who}")
        return True, text
    if loop.phase not in ("ingress", "ready", "pursue"):
        return False, f"not possible in phase {loop.phase}"
    if command.action == "resume":
        failsafes.withdraw(Condition.OPERATOR_HOLD)
        return True, "resumed"
    failsafes.want(Condition.OPERATOR_HOLD, f"hold from {who}")
    return True, "holding position"

"""The fleet as one vehicle sees it: own state and intent out, the others' in, operator commands in."""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Callable, Collection, Iterable

import zenoh

from flightapp.fleet.messages.codec import MalformedPayloadError
from flightapp.fleet.messages.command import Acknowledgement, Command, decode_command, encode_acknowledgement
from flightapp.fleet.messages.intent import INTENT, Intent
from flightapp.fleet.messages.keys import command_key
from flightapp.fleet.messages.state import STATE, State
from flightapp.fleet.peers import Peers
from flightapp.fleet.post import HELD_MAX_S, Post

INTENT_PERIOD_S = 0.5
INTENT_PERIOD_LARGE_S = 1.0
"""The same in a team so large that it has to save packets."""
INTENT_GAP_MIN_S = 0.1
"""Between two intents, however often they change."""
GOAL_MOVED_M = 2.0
"""A goal that moves so far is another intent; one that follows the target slowly is told twice a second."""
COMMAND_AGE_MAX_S = 5.0
ALWAYS_ACCEPTED = ("land", "abort", "rtl")
"""An operator whose clock is wrong must still be able to end a flight."""
COMMANDS_WAITING = 16
"""A ring: who floods loses questions, which are asked again; a full queue would hold up the network's own thread."""
ANSWERS_REMEMBERED = 256


class Team:
    """Polled once a control period; nothing here blocks, queues or starts a thread.

    Zenoh's ring channels keep only the newest sample of each teammate, so sequence gaps between two polls are the
    ring's doing as well as the link's.
    """

    def __init__(
        self,
        session: zenoh.Session,
        fleet: str,
        name: str,
        others: Iterable[str],
        on_malformed: Callable[[str, str], None],
    ) -> None:
        self.post = Post(session, fleet, name, others, on_malformed)
        self._name = name
        self._answered: OrderedDict[str, Acknowledgement] = OrderedDict()
        self._others = Peers(self.post)
        self.peers = self._others.by_name
        self._states, self._intents = self.post.outlet(STATE, addressed=True), self.post.outlet(INTENT)
        self._intent: Intent | None = None
        self._intent_sent_s = -math.inf
        self._commands = session.declare_queryable(command_key(fleet, name), zenoh.handlers.RingChannel(COMMANDS_WAITING))

    def publish(self, state: State, intent: Intent, now_s: float, to: Collection[str] | None = None) -> None:
        """Send `state` to everybody, or to some alone, and `intent` to everybody where it is another one or is due."""
        since_s = now_s - self._intent_sent_s
        period_s = INTENT_PERIOD_LARGE_S if self.post.holds else INTENT_PERIOD_S
        if since_s >= period_s or (since_s >= INTENT_GAP_MIN_S and _is_news(self._intent, intent)):
            self._intent, self._intent_sent_s = intent, now_s
            self._intents.put(intent, now_s)
        if to is None:
            self.post.release(now_s)
            self._states.put(state, now_s)
        else:
            self._states.put_to(to, state, now_s)

    def poll(self, now_s: float) -> None:
        """Take what arrived since the last poll."""
        self._others.poll(now_s)
        self.post.release(now_s, HELD_MAX_S)

    def take_commands(self, now_s: float, accept: Callable[[Command], tuple[bool, str]]) -> list[tuple[Command, Acknowledgement]]:
        """Answer every waiting operator command; a repeat gets the first answer again and changes nothing.

        Returned are the commands that were judged now, with their answers, for the record.
        """
        judged = []
        while (query := self._commands.handler.try_recv()) is not None:
            with query:
                payload = b"" if query.payload is None else query.payload.to_bytes()
                try:
                    command = decode_command(payload)
                except MalformedPayloadError as error:
                    self.post.complain("operator", str(error))
                    query.reply_err(str(error).encode())
                    continue
                answer = self._answered.get(command.identifier)
                if answer is None:
                    accepted, text = self._judge(command, now_s, accept)
                    answer = Acknowledgement(self._name, command.identifier, accepted, text)
                    judged.append((command, answer))
                    self._answered[command.identifier] = answer
                    if len(self._answered) > ANSWERS_REMEMBERED:
                        self._answered.popitem(last=False)
                query.reply(query.key_expr, encode_acknowledgement(answer))
        return judged

    @staticmethod
    def _judge(command: Command, now_s: float, accept: Callable[[Command], tuple[bool, str]]) -> tuple[bool, str]:
        age_s = now_s - command.sent_s
        if command.action not in ALWAYS_ACCEPTED and abs(age_s) > COMMAND_AGE_MAX_S:
            when = f"{age_s:.1f} s old" if age_s > 0.0 else f"stamped {-age_s:.1f} s in the future"
            return False, f"command is {when}; at most {COMMAND_AGE_MAX_S:g} s are accepted: send it again, look at the clocks"
        return accept(command)


def _is_news(before: Intent | None, after: Intent) -> bool:
    if before is None or before.mode != after.mode or before.guards != after.guards:
        return True
    if before.goal_ned_m is None or after.goal_ned_m is None:
        return before.goal_ned_m is not after.goal_ned_m
    return math.dist(before.goal_ned_m, after.goal_ned_m) > GOAL_MOVED_M

"""The fleet as one vehicle sees it: own state out, newest states of the others in, operator commands in."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Iterable

import zenoh

from flightapp.fleet.messages import (
    Acknowledgement,
    Command,
    MalformedPayloadError,
    SharedState,
    command_key,
    decode_command,
    decode_state,
    encode_acknowledgement,
    encode_state,
    state_key,
)

FUTURE_TOLERANCE_S = 0.2
COMMAND_AGE_MAX_S = 5.0
ALWAYS_ACCEPTED = ("land", "abort", "rtl")
"""An operator whose clock is wrong must still be able to end a flight."""
COMMANDS_WAITING = 16
"""A ring: who floods loses questions, which are asked again; a full queue would hold up the network's own thread."""
ANSWERS_REMEMBERED = 256
COMPLAINTS_REMEMBERED = 64


class Peer:
    """Newest accepted state of one other vehicle, with what went wrong on the way."""

    def __init__(self) -> None:
        self.state: SharedState | None = None
        self.lost = 0
        self.rejected = 0
        self.ahead_s = 0.0
        """How far the newest message was stamped ahead of the own clock."""

    def accept(self, state: SharedState, now_s: float) -> bool:
        """Take `state` if it is newer than what is known; reordered, repeated and future-stamped ones are refused."""
        self.ahead_s = state.sent_s - now_s
        if self.ahead_s > FUTURE_TOLERANCE_S or state.t_s > state.sent_s + FUTURE_TOLERANCE_S:
            self.rejected += 1
            return False
        known = self.state
        if known is not None:
            restarted = state.sequence < known.sequence and state.sent_s > known.sent_s
            if state.sent_s <= known.sent_s:
                self.rejected += 1
                return False
            if not restarted:
                self.lost += max(0, state.sequence - known.sequence - 1)
        self.state = state
        return True


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
        self._name = name
        self._on_malformed = on_malformed
        self._sequence = 0
        self._complaints: set[tuple[str, str]] = set()
        self._answered: OrderedDict[str, Acknowledgement] = OrderedDict()
        self.peers = {other: Peer() for other in others}
        self._publisher = session.declare_publisher(
            state_key(fleet, name),
            congestion_control=zenoh.CongestionControl.DROP,
            priority=zenoh.Priority.REAL_TIME,
            express=True,
            reliability=zenoh.Reliability.BEST_EFFORT,
        )
        self._subscribers = {
            other: session.declare_subscriber(state_key(fleet, other), zenoh.handlers.RingChannel(1)) for other in self.peers
        }
        self._commands = session.declare_queryable(command_key(fleet, name), zenoh.handlers.RingChannel(COMMANDS_WAITING))

    def next_sequence(self) -> int:
        self._sequence += 1
        return self._sequence

    def publish(self, state: SharedState) -> None:
        self._publisher.put(encode_state(state))

    def poll(self, now_s: float) -> None:
        """Take what arrived since the last poll."""
        for name, subscriber in self._subscribers.items():
            sample = subscriber.handler.try_recv()
            if sample is None:
                continue
            try:
                state = decode_state(sample.payload.to_bytes())
            except MalformedPayloadError as error:
                self._complain(name, str(error))
                continue
            if state.vehicle != name:
                self._complain(name, f"state on the key of '{name}' claims to be '{state.vehicle}'")
                continue
            peer = self.peers[name]
            if not peer.accept(state, now_s) and peer.ahead_s > FUTURE_TOLERANCE_S:
                self._complain(name, f"states of '{name}' are stamped in the future; synchronise the clocks of the machines")

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
                    self._complain("operator", str(error))
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

    def _complain(self, peer: str, text: str) -> None:
        """Once for each peer and text: a peer that floods must not flood the log as well."""
        if (peer, text) not in self._complaints and len(self._complaints) < COMPLAINTS_REMEMBERED:
            self._complaints.add((peer, text))
            self._on_malformed(peer, text)

    @staticmethod
    def _judge(command: Command, now_s: float, accept: Callable[[Command], tuple[bool, str]]) -> tuple[bool, str]:
        age_s = now_s - command.sent_s
        if command.action not in ALWAYS_ACCEPTED and abs(age_s) > COMMAND_AGE_MAX_S:
            when = f"{age_s:.1f} s old" if age_s > 0.0 else f"stamped {-age_s:.1f} s in the future"
            return False, f"command is {when}; at most {COMMAND_AGE_MAX_S:g} s are accepted: send it again, look at the clocks"
        return accept(command)

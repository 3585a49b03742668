"""What Zenoh refused: connections without a valid certificate, and messages that the access rules forbid.

Zenoh tells neither by its interface; both stand in its log, which goes to standard output. Here that is a file in memory: writing
to it never waits, whatever a stranger makes Zenoh write.
"""

from __future__ import annotations

import fcntl
import os
import re
import sys
from collections import Counter
from collections.abc import Callable, Mapping
from itertools import pairwise

import zenoh

LEVELS = "off,zenoh_link_commons=warn,zenoh_link_tls=warn,zenoh::net::routing::interceptor=trace"
READ_MAX_BYTES = 1 << 16
"""Of what was written since the last look, so that reading never keeps a control loop; in a flood the oldest goes uncounted."""
SENTENCES_MAX = 64
"""Who invents keys must not flood the recording."""
_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
_CONNECTION = re.compile(r"invalid peer certificate: (\w+)|received fatal alert: (\w+)|(peer sent no certificates)")


class ZenohLog:
    """Zenoh's log in place of this process's standard output. One a process; Linux."""

    def __init__(self) -> None:
        self._memory = os.memfd_create("zenoh log")
        fcntl.fcntl(self._memory, fcntl.F_SETFL, os.O_APPEND)
        sys.stdout.flush()
        os.dup2(self._memory, 1)
        zenoh.init_log_from_env_or(LEVELS)

    def take(self) -> str:
        """What was logged since the last call."""
        size = os.fstat(self._memory).st_size
        text = os.pread(self._memory, READ_MAX_BYTES, max(0, size - READ_MAX_BYTES))
        os.ftruncate(self._memory, 0)
        return text.decode(errors="replace")


def refusals(log: str, names: Mapping[str, str]) -> Counter[str]:
    """How often what was refused, as sentences. names: certificate's common name of each Zenoh session that is connected."""
    found: Counter[str] = Counter()
    for before, line in pairwise(["", *log.split("\n")]):
        if "Msg intercepted!" in line:
            found.update(_message(_COLOUR.sub("", before), names))
        elif "certificate" in line or "alert" in line:
            for reasons in _CONNECTION.findall(line):
                found[f"a connection without a valid certificate: {''.join(reasons)}"] += 1
    return found


def _message(line: str, names: Mapping[str, str]) -> list[str]:
    """From `... SESSION[ on LINK] is unauthorized to MESSAGE (ingress) on KEY`."""
    who, separator, what = line.partition(" is unauthorized to ")
    message, incoming, place = what.partition(" (ingress) on ")
    if not (separator and incoming):
        return []
    session = who.partition(" on ")[0].rpartition(" ")[2]
    return [f"'{names.get(session, session)}' may not {message.lower()} on {place}"]


def connected_names(session: zenoh.Session) -> dict[str, str]:
    """Common name of the certificate by identifier of the Zenoh session that showed it."""
    return {str(link.zid): link.auth_identifier for link in session.info.links() if link.auth_identifier}


class RefusalReport:
    """Tells a sentence when it is new and whenever its count has grown tenfold."""

    def __init__(self, tell: Callable[[str], None]) -> None:
        self._tell = tell
        self._counts: Counter[str] = Counter()
        self._told: dict[str, int] = {}

    def add(self, found: Counter[str]) -> None:
        for sentence, count in found.items():
            if sentence not in self._told and len(self._told) >= SENTENCES_MAX:
                continue
            self._counts[sentence] += count
            if self._counts[sentence] >= 10 * self._told.get(sentence, 0):
                self._told[sentence] = self._counts[sentence]
                self._tell(f"refused: {sentence} ({self._counts[sentence]} times so far)")

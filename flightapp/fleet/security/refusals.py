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
from collections.abc import Mapping

import zenoh

LEVELS = "off,zenoh_link_commons=warn,zenoh_link_tls=warn,zenoh::net::routing::interceptor=trace"
READ_MAX_BYTES = 1 << 18
"""Of what was written since the last look; in a flood the oldest of it goes uncounted."""
_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
_MESSAGE = re.compile(r"(\w+)(?: on \S+)? is unauthorized to ([\w/ ]+) \(ingress\) on (\S+)\n[^\n]*Msg intercepted!")
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
    text = _COLOUR.sub("", log)
    found: Counter[str] = Counter()
    for session, message, place in _MESSAGE.findall(text):
        found[f"'{names.get(session, session)}' may not {message.lower()} on {place}"] += 1
    for reasons in _CONNECTION.findall(text):
        found[f"a connection without a valid certificate: {''.join(reasons)}"] += 1
    return found


def connected_names(session: zenoh.Session) -> dict[str, str]:
    """Common name of the certificate by identifier of the Zenoh session that showed it."""
    return {str(link.zid): link.auth_identifier for link in session.info.links() if link.auth_identifier}

"""What this machine and its user are called: the names that must not leave it."""

from __future__ import annotations

import contextlib
import getpass
import os
import platform
import socket
from pathlib import Path

_IDENTITY_FILES = (
    "/etc/machine-id",
    "/sys/class/dmi/id/product_serial",
    "/sys/class/dmi/id/board_serial",
    "/proc/device-tree/serial-number",
)


def own_names() -> set[str]:
    """User, host, home folder and serial numbers of this machine, as far as they can be read."""
    names = {platform.node(), socket.gethostname(), platform.node().split(".")[0], Path.home().name, str(Path.home())}
    names |= {os.environ.get(variable, "") for variable in ("USER", "LOGNAME", "SUDO_USER", "HOSTNAME")}
    with contextlib.suppress(KeyError, OSError):
        names.add(getpass.getuser())
    for path in _IDENTITY_FILES:
        with contextlib.suppress(OSError, UnicodeDecodeError):
            names.add(Path(path).read_text().strip("\x00\n "))
    return {name for name in names if name and name != "/"}

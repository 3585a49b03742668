"""The companion computer's own state, for preflight. Reads the system; nothing here is needed in flight."""

from __future__ import annotations

import ctypes
import shutil
from pathlib import Path

from flightapp.preflight.facts import ComputerFacts

GOVERNORS = "cpu[0-9]*/cpufreq/scaling_governor"
CPUS = Path("/sys/devices/system/cpu")
_TIMEX_BYTES = 256
_TIMEX_STATUS_OFFSET = 40
_STA_UNSYNC = 0x40
"""Linux adjtimex(2): `status` of struct timex, and its flag for a clock that nothing disciplines."""


def computer_facts(recordings: Path) -> ComputerFacts:
    """Free space where `recordings` lie or will lie, CPU governors, clock discipline."""
    return ComputerFacts(_free_bytes(recordings), _governors(), _clock_synchronised())


def _free_bytes(folder: Path) -> int:
    there = folder.absolute()
    while not there.exists():
        there = there.parent
    return shutil.disk_usage(there).free


def _governors() -> tuple[str, ...]:
    found = set()
    for file in CPUS.glob(GOVERNORS):
        try:
            found.add(file.read_text().strip())
        except OSError:
            continue
    return tuple(sorted(found))


def _clock_synchronised() -> bool | None:
    """What the kernel says; None where it does not answer."""
    timex = ctypes.create_string_buffer(_TIMEX_BYTES)
    try:
        answer = ctypes.CDLL(None, use_errno=True).adjtimex(timex)
    except (OSError, AttributeError):
        return None
    if answer < 0:
        return None
    status = int.from_bytes(timex.raw[_TIMEX_STATUS_OFFSET : _TIMEX_STATUS_OFFSET + 4], "little")
    return not status & _STA_UNSYNC

"""What a member must not forget when its process ends and starts again: its term, and its vote in it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import msgspec

from flightapp.core.errors import InputError


@dataclass(frozen=True, slots=True)
class Memory:
    term: int = 0
    vote: str | None = None


class MemoryFile:
    """Small enough to be replaced whole, so that a reader finds the old or the new one.

    The end of a process loses nothing. It is not forced to the disk, which may take longer than a control loop can wait: a
    computer that loses power forgets the last seconds, but is back later than any candidate of that term has patience, and
    then abstains for `timeout_min_s` more.
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    def load(self) -> Memory:
        """What was stored; nothing yet is an empty memory. InputError for a file that holds anything else."""
        try:
            memory = msgspec.json.decode(self._path.read_bytes(), type=Memory)
        except FileNotFoundError:
            return Memory()
        except (msgspec.DecodeError, UnicodeDecodeError) as error:
            raise InputError(
                f"{self._path}: not a stored term and vote ({error}); with the fleet on the ground, delete it"
            ) from None
        if memory.term < 0:
            raise InputError(f"{self._path}: term {memory.term}: must be 0 or more; with the fleet on the ground, delete it")
        return memory

    def store(self, memory: Memory) -> None:
        """OSError where it cannot be written."""
        draft = self._path.with_name(f"{self._path.name}.draft")
        draft.write_bytes(msgspec.json.encode(memory))
        draft.replace(self._path)

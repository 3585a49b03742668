"""MCAP records of a recording, in order, for as far as the file can be read; read as they are asked for, not all at once."""

from __future__ import annotations

import os
from collections.abc import Container, Iterator
from pathlib import Path

from mcap.records import Header, McapRecord, Metadata

from flightapp.core.errors import InputError
from flightapp.recording import file_format
from flightapp.recording.recorder import FILE_PROFILE
from perception.mcap_chunk import RawMessage
from perception.mcap_walk import MAGIC, Losses, Walk, why_no_mcap


class Scan:
    """Iterates over the readable records of one recording: damaged ones are passed over, see `perception.mcap_walk`.

    After an iteration `complete` tells whether the file had its end and nothing was lost, and `note` in one sentence what is
    amiss, empty if nothing is.
    """

    def __init__(self, path: Path) -> None:
        """InputError if `path` is not a recording of this application."""
        self.path = path
        self._ended = False
        self._losses = Losses()
        self._version_note = ""
        try:
            with path.open("rb") as file:
                start = file.read(len(MAGIC))
                self._size = os.fstat(file.fileno()).st_size
        except FileNotFoundError:
            raise InputError(f"{path}: no such file") from None
        except IsADirectoryError:
            raise InputError(f"{path}: is a folder, a recording (.mcap) is wanted") from None
        except OSError as error:
            raise InputError(f"{path}: cannot be read: {error.strerror}") from None
        if why := why_no_mcap(start):
            raise InputError(f"{path}: {why}")
        first = next(self._records(None), None)
        if first is None:
            raise InputError(f"{path}: the recording broke off before its first record; nothing can be read")
        if isinstance(first, Header) and first.profile != FILE_PROFILE:
            raise InputError(
                f"{path}: an MCAP file, but not a recording of this application "
                f"(profile {first.profile[:40]!r}, written by {first.library[:40]!r}; '{FILE_PROFILE}' is wanted)"
            )

    @property
    def complete(self) -> bool:
        """Whether the file had its end and nothing in it was damaged."""
        return self._ended and not self._losses.sentence

    @property
    def losses(self) -> Losses:
        return self._losses

    @property
    def note(self) -> str:
        """What is amiss with the file, one sentence without the file's name; empty if nothing is."""
        cut = "" if self._ended else "breaks off; everything before is used"
        return "; ".join(part for part in (self._losses.sentence, cut, self._version_note) if part)

    def __iter__(self) -> Iterator[McapRecord]:
        return self._records(None)  # type: ignore[return-value]  # bare messages come only where some are wanted

    def messages(self, wanted: Container[int]) -> Iterator[McapRecord | RawMessage]:
        """As by iteration, but messages come bare, and only those whose channel the caller has put into `wanted`."""
        return self._records(wanted)

    def _records(self, wanted: Container[int] | None) -> Iterator[McapRecord | RawMessage]:
        with self.path.open("rb") as file:
            walk = Walk(file, self._size)
            self._losses = walk.losses
            for record in walk.records() if wanted is None else walk.messages(wanted):
                if isinstance(record, Metadata) and record.name == file_format.METADATA:
                    self._version_note = file_format.check_format(self.path, record.metadata)
                yield record
            self._ended = walk.complete

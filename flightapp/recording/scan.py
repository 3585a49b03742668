"""MCAP records of a recording, in order, for as far as the file can be read; read as they are asked for, not all at once."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from mcap.records import Chunk, Footer, Header, McapRecord, Message
from mcap.stream_reader import MAGIC_SIZE, StreamReader

from flightapp.core.errors import InputError
from flightapp.recording.chunks import RawMessage, split
from flightapp.recording.recorder import FILE_PROFILE

_MAGIC = b"\x89MCAP0\r\n"


class Scan:
    """Iterates over the readable records of one recording; `complete` afterwards tells whether the file had its end."""

    def __init__(self, path: Path) -> None:
        """InputError if `path` is not a recording of this application."""
        self.path = path
        self.complete = False
        try:
            with path.open("rb") as file:
                start = file.read(MAGIC_SIZE)
                self._size = os.fstat(file.fileno()).st_size
        except FileNotFoundError:
            raise InputError(f"{path}: no such file") from None
        except IsADirectoryError:
            raise InputError(f"{path}: is a folder, a recording (.mcap) is wanted") from None
        except OSError as error:
            raise InputError(f"{path}: cannot be read: {error.strerror}") from None
        if not start:
            raise InputError(f"{path}: the file is empty; nothing was recorded")
        if start != _MAGIC:
            raise InputError(f"{path}: not a recording: it does not begin like an MCAP file")
        first = next(self._records(), None)
        if not isinstance(first, Header):
            raise InputError(f"{path}: the recording broke off before its first record; nothing can be read")
        if first.profile != FILE_PROFILE:
            raise InputError(f"{path}: an MCAP file, but not a recording of this application (profile '{first.profile}')")

    def __iter__(self) -> Iterator[McapRecord]:
        return self._records()

    def messages(self, wanted: dict[int, str]) -> Iterator[McapRecord | RawMessage]:
        """As by iteration, but messages come bare, and only those whose channel the caller has put into `wanted`."""
        for record in self._records(emit_chunks=True):
            if isinstance(record, Chunk):
                try:
                    yield from split(record, wanted)
                except Exception:  # as in `_records`
                    return
            elif isinstance(record, Message):
                if record.channel_id in wanted:
                    yield record.channel_id, record.log_time, record.data
            else:
                yield record

    def _records(self, *, emit_chunks: bool = False) -> Iterator[McapRecord]:
        """Records up to the end or the first damage. A recording cut off while written ends in damage: that is normal."""
        with self.path.open("rb") as file:
            reader = StreamReader(file, emit_chunks=emit_chunks, validate_crcs=True, record_size_limit=self._size)
            records = reader.records
            while True:
                try:
                    record = next(records)
                except StopIteration:
                    return
                except Exception:  # the decoder answers damage with whatever it stumbles over; each of them is "no further"
                    return
                if isinstance(record, Footer):
                    self.complete = True
                yield record

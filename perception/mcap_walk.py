"""Walks through an MCAP file and passes over what is damaged: of a file with one bad chunk everything else is read.

mcap's own reader ends at the first damage. Here the walk goes on at the next place that can only be the begin of a record: one
whose inner lengths fit its own exactly. Time and memory stay in proportion to the file, whatever the file claims.
"""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Container, Generator, Iterator
from dataclasses import dataclass
from typing import IO, Any

from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    Footer,
    Header,
    McapRecord,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from perception.mcap_chunk import RawMessage, StrictStream, content_of, split, split_whole

MAGIC = b"\x89MCAP0\r\n"
_VERSION_PLACE = 5
"""Of the byte in there that says MCAP's version."""
_HEAD = struct.Struct("<BQ")
_CHUNK_HEAD = struct.Struct("<QQQII")
_COMPRESSIONS = (b"", b"lz4", b"zstd")
_CHUNK_LEAST_BYTES = _HEAD.size + _CHUNK_HEAD.size + 8
_FOOTER_BYTES = _HEAD.size + 20
_PRIVATE = 0x80
"""Opcodes from here on belong to whoever writes the file; readers pass over them."""

_CANDIDATE = re.compile(rb"(?=[\x01-\x04\x06-\x0f].{5}\x00{3})", re.DOTALL)
"""Where a record might begin: a known opcode, not that of a message, and a length below 2^40."""
_WINDOW_BYTES = 1 << 20
_SMALL_RECORD_BYTES = 1 << 20
"""Records other than chunks, attachments and indices are taken for the begin of something readable up to this size."""
_CANDIDATE_COST_BYTES = 1024
"""What looking at one candidate is reckoned as, so that a file full of them does not take for ever."""
_GROWTH = 255
"""Decompressed bytes that are accepted for every byte of the file, which no real recording comes near; and for short ones: """
_GROWTH_FREE_BYTES = 64 << 20

_KINDS: dict[int, Any] = {
    Opcode.HEADER: Header,
    Opcode.FOOTER: Footer,
    Opcode.SCHEMA: Schema,
    Opcode.CHANNEL: Channel,
    Opcode.MESSAGE_INDEX: MessageIndex,
    Opcode.CHUNK: Chunk,
    Opcode.CHUNK_INDEX: ChunkIndex,
    Opcode.ATTACHMENT: Attachment,
    Opcode.ATTACHMENT_INDEX: AttachmentIndex,
    Opcode.STATISTICS: Statistics,
    Opcode.METADATA: Metadata,
    Opcode.METADATA_INDEX: MetadataIndex,
    Opcode.SUMMARY_OFFSET: SummaryOffset,
}
_PARSED = (Opcode.HEADER, Opcode.SCHEMA, Opcode.CHANNEL, Opcode.ATTACHMENT, Opcode.METADATA, Opcode.STATISTICS)
"""Records whose contents are wanted. Indices are not: everything is read in order anyway."""


def why_no_mcap(start: bytes) -> str:
    """What is wrong with the first bytes of a file, one sentence; empty if it begins as an MCAP file does."""
    if not start:
        return "the file is empty; nothing was recorded"
    version = start[_VERSION_PLACE : _VERSION_PLACE + 1]
    if start == MAGIC:
        return ""
    if version and start == MAGIC.replace(b"0", version):
        return f"an MCAP file of version {version.decode(errors='replace')!r}; this program reads MCAP version '0'"
    return "not a recording: it does not begin like an MCAP file"


@dataclass(slots=True)
class Losses:
    """What could not be read, as far as the walk has come."""

    chunks_read: int = 0
    places: int = 0
    """Damaged chunks, and stretches of bytes that are no record."""
    bytes_lost: int = 0
    chunks_written: int | None = None
    """As the file's own statistics have it; None where they are not there."""
    checksum_fits: bool = True
    """False where all chunks were read and something else was changed after it was written."""

    @property
    def chunks_lost(self) -> int:
        """By the file's statistics if they can be true, else one for every damaged place."""
        if self.chunks_written is not None:
            lost = self.chunks_written - self.chunks_read
            if 0 <= lost <= max(self.places, self.bytes_lost // _CHUNK_LEAST_BYTES):
                return lost
        return self.places

    @property
    def sentence(self) -> str:
        """What was lost, for people; empty if nothing was."""
        if self.chunks_lost:
            return f"{self.chunks_lost} of {self.chunks_read + self.chunks_lost} chunks could not be read"
        if self.places:
            return f"{self.bytes_lost} bytes outside its chunks could not be read"
        return (
            ""
            if self.checksum_fits
            else "something outside its chunks was changed after the recording: the checksum does not fit"
        )


class Walk:
    """Goes once over the readable records of an open MCAP file in the order they are in.

    `complete`: the file has its end. `losses`: what was passed over. Both are true to the file once the walk is over.
    """

    def __init__(self, file: IO[bytes], size: int) -> None:
        self.complete = False
        self.losses = Losses()
        self._file = file
        self._size = size
        self._wanted: Container[int] | None = None
        self._reading_left = 4 * size + 16 * _WINDOW_BYTES
        self._growth_left = _GROWTH * size + _GROWTH_FREE_BYTES
        self._checksum: int | None = zlib.crc32(MAGIC)

    def records(self) -> Generator[McapRecord]:
        """All schemas, channels, messages, metadata and attachments; the first one is the header unless that is damaged."""
        return self._walk()  # type: ignore[return-value]  # nothing comes bare where nothing is singled out

    def messages(self, wanted: Container[int]) -> Generator[McapRecord | RawMessage]:
        """As `records`, but without schemas, and bare messages only of channels that the caller has put into `wanted`."""
        self._wanted = wanted
        return self._walk()

    def _walk(self) -> Generator[McapRecord | RawMessage]:
        try:
            yield from self._walked()
        except _TooMuchReadingError:
            self.losses.places += 1

    def _walked(self) -> Iterator[McapRecord | RawMessage]:
        at = len(MAGIC)
        while at < self._size and not self.complete:
            end = self._end_of(at)
            if end is not None:
                intact = yield from self._record(at, end)
                if intact or self._may_begin(end):
                    if not intact:
                        yield from self._lost(end - at)
                    at = end
                    continue
            following = self._next_anchor(at + 1)
            if following is None:
                return  # cut off here, as far as anyone can tell
            yield from self._lost(following - at)
            at = following

    def _record(self, at: int, end: int) -> Generator[McapRecord | RawMessage, None, bool]:
        """Returns whether it is intact."""
        record = self._read(at, end - at)
        opcode, body = record[0], record[_HEAD.size :]
        if opcode == Opcode.DATA_END:
            self._check_data(body)
        if self._checksum is not None:
            self._checksum = zlib.crc32(record, self._checksum)
        if opcode == Opcode.FOOTER:
            self.complete = self._is_footer(at, end)
            return self.complete
        try:
            if opcode == Opcode.CHUNK:
                yield from self._content(_parsed(opcode, body))
            elif opcode == Opcode.MESSAGE:
                yield from self._message(body)
            elif opcode == Opcode.STATISTICS:
                self.losses.chunks_written = _parsed(opcode, body).chunk_count
            elif opcode in _PARSED:
                yield _parsed(opcode, body)
        except ValueError:
            return False
        return True

    def _content(self, chunk: Chunk) -> Iterator[McapRecord | RawMessage]:
        if chunk.uncompressed_size > self._growth_left:
            raise ValueError("more than the file can hold")
        data = content_of(chunk)
        self._growth_left -= len(data)
        yield from split_whole(data) if self._wanted is None else split(data, self._wanted)
        self.losses.chunks_read += 1

    def _message(self, body: bytes) -> Iterator[McapRecord | RawMessage]:
        """A message outside a chunk."""
        data = _HEAD.pack(Opcode.MESSAGE, len(body)) + body
        yield from split_whole(data) if self._wanted is None else split(data, self._wanted)

    def _lost(self, count: int) -> Iterator[McapRecord]:
        """The lost part may have described channels: the summary at the file's end describes them once more."""
        first = self.losses.places == 0
        self.losses.places += 1
        self.losses.bytes_lost += count
        self._checksum = None
        if first:
            yield from self._summary()

    def _summary(self) -> Iterator[McapRecord]:
        """Schemas and channels as repeated at the end of the file; none where that is damaged too."""
        at = self._size - _FOOTER_BYTES - len(MAGIC)
        if at < len(MAGIC) or not self._is_footer(at, at + _FOOTER_BYTES):
            return
        start, _, checksum = struct.unpack("<QQI", self._read(at + _HEAD.size, 20))
        if not len(MAGIC) <= start <= at:
            return
        covered = self._read(start, at + _FOOTER_BYTES - 4 - start)
        if checksum != 0 and zlib.crc32(covered) != checksum:
            return
        here = 0
        while here + _HEAD.size <= len(covered):
            opcode, length = _HEAD.unpack_from(covered, here)
            body = covered[here + _HEAD.size : here + _HEAD.size + length]
            here += _HEAD.size + length
            if opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                try:
                    yield _parsed(opcode, body)
                except ValueError:
                    return

    def _check_data(self, body: bytes) -> None:
        told = int.from_bytes(body[:4], "little")
        if told != 0 and self._checksum is not None and told != self._checksum:
            self.losses.checksum_fits = False

    def _end_of(self, at: int) -> int | None:
        """Where the record at `at` ends by its own word; None where that cannot be."""
        if at + _HEAD.size > self._size:
            return None
        opcode, length = _HEAD.unpack(self._read(at, _HEAD.size))
        end: int = at + _HEAD.size + length
        if end > self._size or not (opcode in _KINDS or opcode in (Opcode.MESSAGE, Opcode.DATA_END) or opcode >= _PRIVATE):
            return None
        return end

    def _may_begin(self, at: int) -> bool:
        """Whether a record may begin at `at`, or the file end."""
        return at == self._size or self._end_of(at) is not None

    def _is_footer(self, at: int, end: int) -> bool:
        return end - at == _FOOTER_BYTES and self._read(at, 1)[0] == Opcode.FOOTER and self._read(end, len(MAGIC)) == MAGIC

    def _next_anchor(self, start: int) -> int | None:
        """The next place from `start` on where a record begins beyond doubt."""
        while start < self._size:
            window = self._read(start, min(_WINDOW_BYTES + _HEAD.size, self._size - start))
            for candidate in _CANDIDATE.finditer(window, 0, len(window)):
                if candidate.start() >= _WINDOW_BYTES:
                    break
                self._charge(_CANDIDATE_COST_BYTES)
                if self._is_anchor(start + candidate.start()):
                    return start + candidate.start()
            start += _WINDOW_BYTES
        return None

    def _is_anchor(self, at: int) -> bool:
        end = self._end_of(at)
        if end is None:
            return False
        opcode, length = self._read(at, 1)[0], end - at - _HEAD.size
        body_at = at + _HEAD.size
        if opcode == Opcode.CHUNK:
            return self._is_chunk(body_at, length)
        if opcode == Opcode.FOOTER:
            return self._is_footer(at, end)
        if opcode == Opcode.DATA_END:
            return length == 4 and self._may_begin(end)
        if opcode == Opcode.MESSAGE_INDEX:
            return length >= 6 and (length - 6) % 16 == 0 and int.from_bytes(self._read(body_at + 2, 4), "little") == length - 6
        if length > _SMALL_RECORD_BYTES and opcode != Opcode.ATTACHMENT:
            return False
        try:
            _parsed(opcode, self._read(body_at, length), exactly=True)
        except ValueError:
            return False
        return True

    def _is_chunk(self, at: int, length: int) -> bool:
        """Whether the lengths within a chunk's head add up to its own."""
        head = self._read(at, min(length, _CHUNK_HEAD.size + 12))
        if len(head) < _CHUNK_HEAD.size + 8:
            return False
        start_ns, end_ns, _, _, width = _CHUNK_HEAD.unpack_from(head)
        after = _CHUNK_HEAD.size + width
        if start_ns > end_ns or width > 4 or head[_CHUNK_HEAD.size : after] not in _COMPRESSIONS or len(head) < after + 8:
            return False
        told: int = after + 8 + int.from_bytes(head[after : after + 8], "little")
        return told == length

    def _read(self, at: int, count: int) -> bytes:
        self._charge(count)
        self._file.seek(at)
        return self._file.read(count)

    def _charge(self, count: int) -> None:
        self._reading_left -= count
        if self._reading_left < 0:
            raise _TooMuchReadingError


class _TooMuchReadingError(Exception):
    """The file is made so that looking for its records would take for ever."""


def _parsed(opcode: int, body: bytes, *, exactly: bool = False) -> Any:
    """The record; ValueError if it is damaged. exactly: also if bytes are left over, as a newer format may have."""
    stream = StrictStream(body)
    try:
        record = _KINDS[opcode].read(stream)
    except Exception as error:  # the decoder answers damage with whatever it stumbles over
        raise ValueError(f"a damaged record: {error}") from None
    if exactly and stream.count != len(body):
        raise ValueError("bytes are left over")
    if isinstance(record, Attachment) and not _attachment_is_whole(body):
        raise ValueError("an attachment whose checksum does not fit")
    return record


def _attachment_is_whole(body: bytes) -> bool:
    told = int.from_bytes(body[-4:], "little")
    return told == 0 or zlib.crc32(body[:-4]) == told

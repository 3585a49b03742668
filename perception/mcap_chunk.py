"""What is inside one chunk of an MCAP file: decompressed within bounds, checked, and taken apart.

It stands here and not in flightapp.recording because both read recordings, and perception knows nothing of flightapp.
"""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Container, Iterator
from typing import Any

import lz4.frame
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Message, Schema

CHUNK_MAX_BYTES = 1 << 28
"""Decompressed. Recorders write chunks of at most a few MiB; what claims to be larger than this is damaged, or meant to hurt."""
_LZ4_BEST_RATIO = 255
_PIECE_BYTES = 1 << 20

_HEAD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")

RawMessage = tuple[int, int, bytes]
"""Channel, time in ns, payload."""


class StrictStream(ReadDataStream):
    """Refuses to return less than was asked for, where mcap's own reader takes what there is. EOFError."""

    def __init__(self, data: bytes) -> None:
        super().__init__(io.BytesIO(data))

    def read(self, length: int) -> bytes:
        data = super().read(length)
        if len(data) != length:
            raise EOFError(f"{length} bytes wanted, {len(data)} there")
        return data


def content_of(chunk: Chunk) -> bytes:
    """The records in `chunk`; ValueError where it is damaged. Takes no more memory than the chunk says it needs."""
    if chunk.uncompressed_size > CHUNK_MAX_BYTES:
        raise ValueError(f"a chunk of {chunk.uncompressed_size} bytes")
    try:
        data = _decompressed(chunk)
    except (RuntimeError, zstandard.ZstdError, EOFError) as error:
        raise ValueError(f"a chunk that cannot be decompressed: {error}") from None
    if len(data) != chunk.uncompressed_size:
        raise ValueError("a chunk of another size than it says")
    if chunk.uncompressed_crc != 0 and zlib.crc32(data) != chunk.uncompressed_crc:
        raise ValueError("a chunk whose checksum does not fit")
    return data


def split(data: bytes, wanted: Container[int]) -> Iterator[Channel | RawMessage]:
    """The channels in a chunk's content, and bare the messages of channels in `wanted`, which the caller may extend meanwhile.

    Fast, because a long flight has a million messages and most are never looked at. ValueError where it is damaged.
    """
    for opcode, start, end in _records(data):
        if opcode == Opcode.MESSAGE:
            channel, _, time_ns, _ = _message_head(data, start, end)
            if channel in wanted:
                yield channel, time_ns, data[start + _MESSAGE.size : end]
        elif opcode == Opcode.CHANNEL:
            yield _parsed(Channel, data[start:end])


def split_whole(data: bytes) -> Iterator[Schema | Channel | Message]:
    """Every schema, channel and message in a chunk's content. ValueError where it is damaged."""
    for opcode, start, end in _records(data):
        if opcode == Opcode.MESSAGE:
            channel, sequence, time_ns, published_ns = _message_head(data, start, end)
            yield Message(channel, time_ns, data[start + _MESSAGE.size : end], published_ns, sequence)
        elif opcode == Opcode.CHANNEL:
            yield _parsed(Channel, data[start:end])
        elif opcode == Opcode.SCHEMA:
            yield _parsed(Schema, data[start:end])


def _records(data: bytes) -> Iterator[tuple[int, int, int]]:
    """(opcode, start, end) of each record's body."""
    at, size = 0, len(data)
    while at < size:
        if at + _HEAD.size > size:
            raise ValueError("a chunk that ends within a record")
        opcode, length = _HEAD.unpack_from(data, at)
        start = at + _HEAD.size
        at = start + length
        if at > size or opcode == 0:
            raise ValueError("a chunk whose records do not fit into it")
        yield opcode, start, at


def _message_head(data: bytes, start: int, end: int) -> tuple[int, int, int, int]:
    if end - start < _MESSAGE.size:
        raise ValueError("a message too short for its own head")
    channel, sequence, time_ns, published_ns = _MESSAGE.unpack_from(data, start)
    return channel, sequence, time_ns, published_ns


def _parsed(kind: type[Channel] | type[Schema], body: bytes) -> Any:
    try:
        return kind.read(StrictStream(body))
    except Exception as error:  # the decoder answers damage with whatever it stumbles over
        raise ValueError(f"a damaged {kind.__name__}: {error}") from None


def _decompressed(chunk: Chunk) -> bytes:
    """At most one byte more than the chunk should have, however much its frame would give."""
    limit = chunk.uncompressed_size + 1
    if chunk.compression == "":
        return chunk.data
    if chunk.compression == "lz4":
        limit = min(limit, _LZ4_BEST_RATIO * len(chunk.data) + 1)
        return bytes(lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=limit))
    if chunk.compression == "zstd":
        with zstandard.ZstdDecompressor().stream_reader(chunk.data) as stream:
            pieces = []
            while limit > 0 and (piece := stream.read(min(limit, _PIECE_BYTES))):
                pieces.append(piece)
                limit -= len(piece)
            return b"".join(pieces)
    raise ValueError(f"compression '{chunk.compression}', which this program does not know")

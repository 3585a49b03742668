"""Messages out of one chunk of a recording, fast: a long flight has a million of them, and most are never looked at."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from io import BytesIO

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk
from mcap.stream_reader import get_chunk_data_stream

_HEAD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")

RawMessage = tuple[int, int, bytes]
"""Channel, time in ns, payload."""


def split(chunk: Chunk, wanted: dict[int, str]) -> Iterator[Channel | RawMessage]:
    """The channels in `chunk`, and the messages of the channels in `wanted`, which the caller may extend meanwhile.

    ValueError, struct.error or what the decompressor raises where the chunk is damaged.
    """
    stream, size = get_chunk_data_stream(chunk, validate_crc=True)
    data = stream.read(size)
    at = 0
    while at < size:
        opcode, length = _HEAD.unpack_from(data, at)
        start = at + _HEAD.size
        at = start + length
        if at > size:
            raise ValueError("a record reaches beyond its chunk")
        if opcode == Opcode.MESSAGE:
            channel, _, time_ns, _ = _MESSAGE.unpack_from(data, start)
            if channel in wanted:
                yield channel, time_ns, data[start + _MESSAGE.size : at]
        elif opcode == Opcode.CHANNEL:
            yield Channel.read(ReadDataStream(BytesIO(data[start:at])))

"""Small recordings, and all the ways in which a file goes wrong: deterministic by seed."""

from __future__ import annotations

import random
import struct
import tempfile
import zlib
from collections.abc import Callable
from pathlib import Path

import lz4.frame
import zstandard
from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.writer import CompressionType, Writer

from flightapp.config.mission import load_mission
from flightapp.recording.scan import Scan
from tests.analysis.synthetic_run import MISSION, write_vehicle
from tests.recording.depth_flight import frames, history, record

HEAD = struct.Struct("<BQ")
MAGIC_BYTES = 8
CHUNK, MESSAGE, DATA_END = 0x06, 0x05, 0x0F
HUGE = (2**64 - 1, 2**63, 2**40, 2**32, 2**31 - 1, 10**9, 0)
PAYLOADS = (
    b"",
    b"not JSON",
    b"null",
    b"[1, 2, 3]",
    b'"text"',
    b"{",
    b'{"t_s": NaN, "position_ned_m": [NaN, Infinity, -Infinity]}',
    b'{"t_s": "soon", "position_ned_m": "here", "velocity_ned_m_s": {"north": 1}, "phase": 7, "discs": 3, "members": [[]]}',
    b'{"t_s": 1e999, "position_ned_m": [1e308, -1e308, 1e308], "velocity_ned_m_s": [1, 2], "vehicle": ["p1"], "phase": {}}',
    b'{"t_s": ' + b"9" * 400 + b"}",
    b'{"t_s": null, "phase": null, "level": [], "data": 5, "name": {}, "outcome": 1, "members": 7, "ahead_s": "x"}',
    b"[" * 3000 + b"]" * 3000,
    b'{"t_s":' * 3000,
    b'{"phase": "\xff\xfe\x80", "t_s": 1.0}',
    b'{"phase": "\\ud800", "level": "error", "name": "\\u0000"}',
)

Mutation = Callable[[random.Random, bytes, bytes], bytes]


def base_files() -> tuple[bytes, ...]:
    """Short flights of a few kB in many chunks: lz4, zstd, uncompressed, without chunks, cut off; and one with depth frames."""
    with tempfile.TemporaryDirectory() as folder:
        flight = Path(folder) / "p1.mcap"
        write_vehicle(flight, "p1", load_mission(MISSION), seed=1, duration_s=14.0)
        kept = [rewritten(flight, kind) for kind in (CompressionType.LZ4, CompressionType.ZSTD, CompressionType.NONE)]
        depth = record(Path(folder) / "depth.mcap", frames(2), history()).read_bytes()
        return (*kept, rewritten(flight, CompressionType.NONE, use_chunking=False), kept[0][: len(kept[0]) * 2 // 3], depth)


def rewritten(source: Path, compression: CompressionType, *, use_chunking: bool = True, every: int = 60) -> bytes:
    """The recording with every so-manieth message, in small chunks."""
    target = source.with_suffix(".rewritten")
    with target.open("wb") as file:
        writer = Writer(file, chunk_size=700, compression=compression, use_chunking=use_chunking, enable_data_crcs=True)
        writer.start(profile="flightapp", library="test")
        schemas: dict[int, int] = {0: 0}
        channels: dict[int, int] = {}
        for number, part in enumerate(Scan(source)):
            if isinstance(part, Schema) and part.id not in schemas:
                schemas[part.id] = writer.register_schema(
                    part.name, part.encoding, b"{}" if part.encoding == "jsonschema" else b""
                )
            elif isinstance(part, Channel) and part.id not in channels:
                channels[part.id] = writer.register_channel(part.topic, part.message_encoding, schemas[part.schema_id])
            elif isinstance(part, Message) and number % every == 0:
                writer.add_message(channels[part.channel_id], part.log_time, part.data, part.publish_time, part.sequence)
            elif isinstance(part, Metadata):
                writer.add_metadata(part.name, part.metadata)
            elif isinstance(part, Attachment):
                writer.add_attachment(part.create_time, part.log_time, part.name, part.media_type, part.data)
        writer.finish()  # type: ignore[no-untyped-call]
    return target.read_bytes()


def records_of(data: bytes) -> list[tuple[int, int]]:
    """(begin, end) of the top-level records of an intact file, as far as its lengths lead."""
    found, at = [], MAGIC_BYTES
    while at + HEAD.size <= len(data):
        end = at + HEAD.size + HEAD.unpack_from(data, at)[1]
        if end > len(data):
            break
        found.append((at, end))
        at = end
    return found


def mutated(chance: random.Random, data: bytes, other: bytes) -> tuple[str, bytes]:
    """The name of what was done to `data`, and the result; sometimes several things at once."""
    name = chance.choice(list(MUTATIONS))
    data = MUTATIONS[name](chance, data, other)
    while chance.random() < 0.15:
        data = chance.choice(list(MUTATIONS.values()))(chance, data, other)
    return name, data


def _flip_bits(chance: random.Random, data: bytes, other: bytes) -> bytes:
    changed = bytearray(data)
    for _ in range(chance.choice((1, 1, 2, 8, 64)) if data else 0):
        changed[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
    return bytes(changed)


def _range(chance: random.Random, data: bytes) -> tuple[int, int]:
    start = chance.randrange(len(data) + 1)
    return start, min(len(data), start + chance.choice((1, 4, 9, 100, 1000, 5000)))


def _zero(chance: random.Random, data: bytes, other: bytes) -> bytes:
    start, end = _range(chance, data)
    return data[:start] + bytes(end - start) + data[end:]


def _randomise(chance: random.Random, data: bytes, other: bytes) -> bytes:
    start, end = _range(chance, data)
    return data[:start] + chance.randbytes(end - start) + data[end:]


def _remove(chance: random.Random, data: bytes, other: bytes) -> bytes:
    start, end = _range(chance, data)
    return data[:start] + data[end:]


def _insert(chance: random.Random, data: bytes, other: bytes) -> bytes:
    start, _ = _range(chance, data)
    return data[:start] + chance.randbytes(chance.choice((1, 7, 64, 500))) + data[start:]


def _truncate(chance: random.Random, data: bytes, other: bytes) -> bytes:
    return data[: chance.randrange(len(data) + 1)]


def _splice(chance: random.Random, data: bytes, other: bytes) -> bytes:
    return data[: chance.randrange(len(data) + 1)] + other[chance.randrange(len(other) + 1) :]


def _splice_records(chance: random.Random, data: bytes, other: bytes) -> bytes:
    """Joined between two records: both halves are intact in themselves."""
    first, second = records_of(data), records_of(other)
    if not first or not second:
        return data + other
    return data[: chance.choice(first)[1]] + other[chance.choice(second)[0] :]


def _shuffle_records(chance: random.Random, data: bytes, other: bytes) -> bytes:
    """Some records twice, some missing, some in another order."""
    parts = [data[begin:end] for begin, end in records_of(data)]
    for _ in range(chance.randrange(1, 4)):
        if parts:
            part = parts.pop(chance.randrange(len(parts)))
            for _ in range(chance.choice((0, 1, 1, 2, 3))):
                parts.insert(chance.randrange(len(parts) + 1), part)
    return data[:MAGIC_BYTES] + b"".join(parts) + data[-MAGIC_BYTES:]


def _lie_about_length(chance: random.Random, data: bytes, other: bytes) -> bytes:
    """A record's own length, or a length somewhere in its first bytes."""
    places = records_of(data)
    if not places:
        return data
    begin, end = chance.choice(places)
    at, width = chance.choice(((begin + 1, 8), (begin + chance.randrange(9, 60), 4), (begin + chance.randrange(9, 60), 8)))
    value = chance.choice((*HUGE, end - begin - 9 + chance.choice((-9, -1, 1, 9)), len(data)))
    return data[:at] + (value % 2 ** (8 * width)).to_bytes(width, "little") + data[at + width :]


def _other_opcode(chance: random.Random, data: bytes, other: bytes) -> bytes:
    places = records_of(data)
    if not places:
        return data
    begin, _ = chance.choice(places)
    return (
        data[:begin]
        + bytes([chance.choice((0, chance.randrange(1, 16), chance.randrange(16, 128), 200, 255))])
        + data[begin + 1 :]
    )


def _foreign_record(chance: random.Random, data: bytes, other: bytes) -> bytes:
    """A well-formed record that no recorder writes there."""
    body = chance.randbytes(chance.choice((0, 4, 20, 22, 30, 400)))
    opcode = chance.choice((*range(1, 16), 0x42, 0x80, 0xFF))
    return _between_records(chance, data, HEAD.pack(opcode, len(body)) + body)


def _other_metadata(chance: random.Random, data: bytes, other: bytes) -> bytes:
    """Versions, names and numbers that are not what they should be, well-formed."""
    wrong = {
        "format": {"version": chance.choice(("1.1", "1.7", "2.0", "0.9", "", "x", "99999999999.0", "1.0\n"))},
        "run": {"vehicle": chance.choice(("", "p9", "../../x", "\x00", "p1" * 500)), "seed": chance.choice(("", "x", "-", "٣"))},
        "clock_offsets": {"p2": chance.choice(("nan", "1e300", "x", "")), "p1": "5"},
        "recording": {"dropped": chance.choice(("x", "-1", "1e9", "9" * 50))},
    }
    name = chance.choice(list(wrong))
    content = b"".join(_text(key) + _text(value) for key, value in wrong[name].items())
    body = _text(name) + struct.pack("<I", len(content)) + content
    return _between_records(chance, data, HEAD.pack(0x0C, len(body)) + body)


def _other_attachment(chance: random.Random, data: bytes, other: bytes) -> bytes:
    content = chance.choice((b"", b"\xff\xfe", b"name = ", b"[a]\n" * 50, b"a = " + b"[" * 5000, chance.randbytes(50)))
    name = chance.choice(("mission.toml", "profile.toml", "../x", ""))
    body = struct.pack("<QQ", 1, 1) + _text(name) + _text("text") + struct.pack("<Q", len(content)) + content
    body += struct.pack("<I", zlib.crc32(body))
    return _between_records(chance, data, HEAD.pack(0x09, len(body)) + body)


def _other_header(chance: random.Random, data: bytes, other: bytes) -> bytes:
    body = _text(chance.choice(("", "ros2", "flightapp", "x" * 5000, "flightapp2"))) + _text(chance.choice(("", "mcap go", "\n")))
    return (
        data[:MAGIC_BYTES] + HEAD.pack(1, len(body)) + body + data[records_of(data)[0][1] if records_of(data) else MAGIC_BYTES :]
    )


def _other_magic(chance: random.Random, data: bytes, other: bytes) -> bytes:
    return chance.choice((b"\x89MCAP1\r\n", b"\x89MCAP\xff\r\n", b"#ROSBAG V2.0\n", b"", b"\x00" * 8)) + data[MAGIC_BYTES:]


def _other_payload(chance: random.Random, data: bytes, other: bytes) -> bytes:
    """A chunk with a right checksum whose messages hold what no recorder writes."""

    def worse(content: bytes) -> bytes:
        parts = []
        for begin, end in ((at - MAGIC_BYTES, to - MAGIC_BYTES) for at, to in records_of(bytes(MAGIC_BYTES) + content)):
            part = content[begin:end]
            if part[0] == MESSAGE and chance.random() < 0.5:
                body = bytearray(part[HEAD.size : HEAD.size + 22])
                if chance.random() < 0.3:
                    struct.pack_into("<QQ", body, 6, chance.choice(HUGE), chance.choice(HUGE))
                if chance.random() < 0.2:
                    struct.pack_into("<H", body, 0, chance.randrange(65536))
                payload = chance.choice((*PAYLOADS, _flip_bits(chance, part[HEAD.size + 22 :], b"")))
                part = HEAD.pack(MESSAGE, len(body) + len(payload)) + bytes(body) + payload
            if chance.random() > 0.05:
                parts.append(part)
        return b"".join(parts)

    return _with_chunk(chance, data, worse, lie=False)


def _other_content(chance: random.Random, data: bytes, other: bytes) -> bytes:
    """A chunk with a right checksum whose records are damaged."""
    return _with_chunk(chance, data, lambda content: chance.choice((_flip_bits, _zero, _remove))(chance, content, b""), lie=False)


def _bomb(chance: random.Random, data: bytes, other: bytes) -> bytes:
    """A chunk that is far larger than its bytes, in truth or by its word."""
    size = chance.choice((0, 1 << 16, 1 << 22))
    filling = HEAD.pack(chance.choice((0x80, MESSAGE)), size) + bytes(size) if size else b""
    return _with_chunk(chance, data, lambda content: content + filling, lie=chance.random() < 0.7)


def _with_chunk(chance: random.Random, data: bytes, change: Callable[[bytes], bytes], *, lie: bool) -> bytes:
    """One chunk of the file changed and packed again."""
    chunks = [(begin, end) for begin, end in records_of(data) if data[begin] == CHUNK]
    if not chunks:
        return data
    begin, end = chance.choice(chunks)
    try:
        first, last, _, _, width = struct.unpack_from("<QQQII", data, begin + HEAD.size)
        packed = data[begin + HEAD.size + 32 + width + 8 : end]
        kind = data[begin + HEAD.size + 32 : begin + HEAD.size + 32 + width]
        content = _UNPACK[kind](packed)
    except Exception:  # damaged by an earlier mutation
        return data
    content = change(content)
    kind = chance.choice(list(_PACK))
    size = chance.choice((*HUGE, len(content) + 1)) if lie else len(content)
    checksum = chance.choice((0, zlib.crc32(content)))
    packed = _PACK[kind](content)
    body = struct.pack("<QQQII", first, last, size, checksum, len(kind)) + kind + struct.pack("<Q", len(packed)) + packed
    return data[:begin] + HEAD.pack(CHUNK, len(body)) + body + data[end:]


def _between_records(chance: random.Random, data: bytes, record: bytes) -> bytes:
    places = records_of(data)
    at = chance.choice(places[: chance.choice((2, len(places)))])[1] if places else len(data)
    return data[:at] + record + data[at:]


def _text(text: str) -> bytes:
    data = text.encode()
    return struct.pack("<I", len(data)) + data


_PACK: dict[bytes, Callable[[bytes], bytes]] = {
    b"": lambda content: content,
    b"lz4": lz4.frame.compress,
    b"zstd": zstandard.ZstdCompressor().compress,
}
_UNPACK: dict[bytes, Callable[[bytes], bytes]] = {
    b"": lambda packed: packed,
    b"lz4": lz4.frame.decompress,
    b"zstd": lambda packed: zstandard.ZstdDecompressor().decompress(packed, 1 << 24),
}

MUTATIONS: dict[str, Mutation] = {
    "bits flipped": _flip_bits,
    "bytes zeroed": _zero,
    "bytes at random": _randomise,
    "bytes removed": _remove,
    "bytes inserted": _insert,
    "cut off": _truncate,
    "two files joined": _splice,
    "two files joined at records": _splice_records,
    "records shuffled": _shuffle_records,
    "wrong lengths": _lie_about_length,
    "other opcodes": _other_opcode,
    "foreign records": _foreign_record,
    "other metadata": _other_metadata,
    "other attachments": _other_attachment,
    "other header": _other_header,
    "other magic": _other_magic,
    "other messages": _other_payload,
    "damaged chunk contents": _other_content,
    "compression bombs": _bomb,
}

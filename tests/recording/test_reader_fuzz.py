"""Damaged recordings: whatever is readable is read, the rest is named in one sentence; nothing hangs, grows or breaks."""

from __future__ import annotations

import json
import random
import struct
import subprocess
import sys
import zlib
from collections.abc import Callable
from pathlib import Path

import pytest
from mcap.records import Message
from mcap.writer import CompressionType, Writer

from flightapp.cli import main
from flightapp.core.errors import InputError
from flightapp.recording.reader import read_recording
from flightapp.recording.recover import recover
from flightapp.recording.scan import Scan
from perception.cli import main as perception_main
from perception.sources.mcap import McapSource
from tests.recording.depth_flight import frames, history, record
from tests.recording.mutations import CHUNK, HEAD, MUTATIONS, base_files, mutated, records_of

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def flight() -> bytes:
    """A short flight in several lz4 chunks."""
    return base_files()[0]


def chunks_of(data: bytes) -> list[tuple[int, int]]:
    return [(begin, end) for begin, end in records_of(data) if data[begin] == CHUNK]


def with_metadata(data: bytes, name: str, content: dict[str, str]) -> bytes:
    """One more metadata record behind the header."""

    def text(value: str) -> bytes:
        return struct.pack("<I", len(value.encode())) + value.encode()

    pairs = b"".join(text(key) + text(value) for key, value in content.items())
    body = text(name) + struct.pack("<I", len(pairs)) + pairs
    at = records_of(data)[0][1]
    return data[:at] + HEAD.pack(0x0C, len(body)) + body + data[at:]


def messages_in(path: Path) -> list[tuple[int, bytes]]:
    return [(record.log_time, record.data) for record in Scan(path) if isinstance(record, Message)]


def test_no_mutation_breaks_a_reader() -> None:
    """In a process of its own, whose memory is limited; with a hundred times as many see `fuzz_reader`."""
    command = [sys.executable, "-m", "tests.recording.fuzz_reader", "--mutations", "200"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("name", MUTATIONS)
def test_every_mutation_is_felt(name: str, flight: bytes) -> None:
    chance = random.Random(4)
    assert any(MUTATIONS[name](chance, flight, flight[: len(flight) // 2]) != flight for _ in range(20))


def test_mutations_are_the_same_for_the_same_seed(flight: bytes) -> None:
    assert mutated(random.Random(7), flight, flight) == mutated(random.Random(7), flight, flight)


@pytest.mark.parametrize(
    "damage",
    [
        pytest.param(lambda data, begin, end: data[: end - 20] + b"damaged" + data[end - 13 :], id="content"),
        pytest.param(lambda data, begin, end: data[: begin + 1] + b"\xff" * 8 + data[begin + 9 :], id="huge length"),
        pytest.param(lambda data, begin, end: data[: begin + 1] + b"\x07" + bytes(7) + data[begin + 9 :], id="small length"),
        pytest.param(lambda data, begin, end: data[: begin + 25] + b"\xff" * 8 + data[begin + 33 :], id="huge content"),
        pytest.param(lambda data, begin, end: data[: begin - 5] + bytes(60) + data[begin + 55 :], id="zeros"),
        pytest.param(lambda data, begin, end: data[: begin + 30] + data[begin + 130 :], id="bytes missing"),
        pytest.param(lambda data, begin, end: data[:begin] + bytes(4096) + data[begin:], id="bytes added"),
    ],
)
@pytest.mark.parametrize("place", [0, 2, -1])
def test_all_but_the_damaged_chunk_is_read(
    tmp_path: Path, flight: bytes, place: int, damage: Callable[[bytes, int, int], bytes], request: pytest.FixtureRequest
) -> None:
    whole, path = tmp_path / "whole.mcap", tmp_path / "p1.mcap"
    whole.write_bytes(flight)
    chunks = chunks_of(flight)
    begin, end = chunks[place]
    path.write_bytes(damage(flight, begin, end))
    alone = tmp_path / "without.mcap"
    alone.write_bytes(flight[:begin] + flight[end:])

    added = "bytes added" in request.node.name
    expected = messages_in(whole if added else alone)
    assert messages_in(path) == expected

    recording = read_recording(path)
    assert not recording.complete
    assert ("4096 bytes outside its chunks" if added else f"1 of {len(chunks)} chunks could not be read") in recording.note
    assert "\n" not in recording.note
    if place != 0 and not added:
        assert 0 < sum(map(len, recording.series.values())) < len(messages_in(whole))


def test_losing_the_chunk_that_describes_the_channels_loses_no_other_chunk(tmp_path: Path, flight: bytes) -> None:
    whole, path = tmp_path / "whole.mcap", tmp_path / "p1.mcap"
    whole.write_bytes(flight)
    begin, _ = chunks_of(flight)[0]
    path.write_bytes(flight[: begin + 80] + b"damaged" + flight[begin + 87 :])
    lost = len(messages_in(whole)) - len(messages_in(path))
    kept = sum(map(len, read_recording(path).series.values()))
    assert lost > 0
    assert kept >= sum(map(len, read_recording(whole).series.values())) - lost > 0


def test_recover_makes_a_normal_file_and_says_what_is_lost(
    tmp_path: Path, flight: bytes, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    chunks = chunks_of(flight)
    _, end = chunks[1]
    path = tmp_path / "p1.mcap"
    path.write_bytes(flight[: end - 9] + b"\x00damage\x00\x01" + flight[end:])
    monkeypatch.setattr(sys, "argv", ["flightapp", "recover", str(path)])
    with pytest.raises(SystemExit) as left:
        main()
    assert not left.value.code
    assert f"{path}: 1 of {len(chunks)} chunks could not be read" in capsys.readouterr().out
    recovered = tmp_path / "p1-recovered.mcap"
    assert messages_in(recovered) == messages_in(path)
    assert read_recording(recovered).complete
    assert read_recording(recovered).note == ""


def test_a_change_outside_the_chunks_is_noticed(tmp_path: Path, flight: bytes) -> None:
    path = tmp_path / "p1.mcap"
    at = flight.index(b"demo_two_pursuers")
    path.write_bytes(flight[:at] + b"d" + b"E" + flight[at + 2 :])
    recording = read_recording(path)
    assert not recording.complete
    assert "outside its chunks" in recording.note


def test_two_recordings_one_behind_the_other_keep_their_topics(tmp_path: Path, flight: bytes) -> None:
    """The number of a channel means another topic from the joint on."""
    other = tmp_path / "other.mcap"
    with other.open("wb") as file:
        writer = Writer(file, compression=CompressionType.NONE)
        writer.start(profile="flightapp")
        channel = writer.register_channel("/another", "json", 0)
        writer.add_message(channel, 10**9, b'{"t_s": 1.0}', 10**9)
        writer.finish()  # type: ignore[no-untyped-call]
    second = other.read_bytes()
    path, output = tmp_path / "p1.mcap", tmp_path / "out.mcap"
    path.write_bytes(flight[: chunks_of(flight)[-1][1]] + second[records_of(second)[0][1] :])
    recover(path, output)
    for file_path in (path, output):
        assert read_recording(file_path).topic("/another").column("t_s").tolist() == [1.0]


@pytest.mark.parametrize("compression", [b"lz4", b"zstd", b""])
def test_a_chunk_that_claims_to_be_huge_takes_no_memory(tmp_path: Path, flight: bytes, compression: bytes) -> None:
    import tracemalloc

    begin, end = chunks_of(flight)[1]
    content = b"\x04\x22\x4d\x18\x60\x40\x82" if compression == b"lz4" else b"\x28\xb5\x2f\xfd\xe0" + b"\xff" * 8
    body = struct.pack("<QQQII", 0, 1, 2**62, 0, len(compression)) + compression + struct.pack("<Q", len(content)) + content
    path = tmp_path / "p1.mcap"
    path.write_bytes(flight[:begin] + HEAD.pack(CHUNK, len(body)) + body + flight[end:])
    tracemalloc.start()
    try:
        recording = read_recording(path)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert "1 of" in recording.note
    assert peak < 20_000_000


def test_a_compression_bomb_is_not_unpacked(tmp_path: Path) -> None:
    """True sizes and checksums: a thousand chunks of 16 MiB in a file of 1 MB would fill any memory."""
    import zstandard

    message = struct.pack("<HIQQ", 1, 1, 1, 1) + bytes(1 << 24)
    content = HEAD.pack(5, len(message)) + message
    packed = zstandard.ZstdCompressor().compress(content)
    body = struct.pack("<QQQII", 0, 1, len(content), zlib.crc32(content), 4) + b"zstd" + struct.pack("<Q", len(packed)) + packed
    with (tmp_path / "p1.mcap").open("wb") as file:
        writer = Writer(file, use_chunking=False)
        writer.start(profile="flightapp")
        writer.register_channel("/own", "json", 0)
        writer.finish()  # type: ignore[no-untyped-call]
    data = (tmp_path / "p1.mcap").read_bytes()
    at = records_of(data)[1][1]
    path = tmp_path / "bomb.mcap"
    path.write_bytes(data[:at] + (HEAD.pack(CHUNK, len(body)) + body) * 40 + data[at:])
    recording = read_recording(path)
    kept = len(recording.series.get("/own", ()))
    assert kept < 10
    assert f"{40 - kept} of 40 chunks could not be read" in recording.note


@pytest.mark.parametrize(
    ("told", "words"),
    [
        ({"version": "2.0"}, ["format 2.0", "reads format 1.x", "a newer one"]),
        ({"version": "0.3"}, ["format 0.3", "reads format 1.x", "an older one"]),
    ],
)
def test_another_major_version_is_refused(tmp_path: Path, flight: bytes, told: dict[str, str], words: list[str]) -> None:
    path = tmp_path / "p1.mcap"
    path.write_bytes(with_metadata(flight, "format", told))
    for read in (read_recording, lambda file: recover(file, tmp_path / "out.mcap")):
        with pytest.raises(InputError) as refused:
            read(path)
        for word in ("p1.mcap", *words):
            assert word in str(refused.value)
    assert list(tmp_path.iterdir()) == [path]


def test_a_newer_minor_version_is_read_and_said_once(tmp_path: Path, flight: bytes) -> None:
    path = tmp_path / "p1.mcap"
    assert flight.count(b"version\x03\0\0\x001.0") >= 1
    path.write_bytes(flight.replace(b"version\x03\0\0\x001.0", b"version\x03\0\0\x001.9"))
    note = read_recording(path).note
    assert note.count("is of format 1.9, newer than this program's 1.0") == 1
    (tmp_path / "old.mcap").write_bytes(flight)
    assert read_recording(path).series.keys() == read_recording(tmp_path / "old.mcap").series.keys()


def foreign(path: Path) -> bytes:
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2", library="rosbag2_storage_mcap 0.26")
        writer.finish()  # type: ignore[no-untyped-call]
    return path.read_bytes()


@pytest.mark.parametrize("command", [("report",), ("recover",), ("perception", "--no-window")])
@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("empty", "the file is empty"),
        ("text", "does not begin like an MCAP file"),
        ("cut in the header", "broke off before its first record"),
        ("foreign", "(profile 'ros2', written by 'rosbag2_storage_mcap 0.26'"),
        ("newer MCAP", "an MCAP file of version '1'; this program reads MCAP version '0'"),
        ("missing", "no such file"),
    ],
)
def test_what_is_no_recording_is_refused_in_one_sentence(
    tmp_path: Path,
    command: tuple[str, ...],
    kind: str,
    words: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    flight: bytes,
) -> None:
    path = tmp_path / "x.mcap"
    contents = {
        "empty": b"",
        "text": b"# a text file\n",
        "cut in the header": flight[:15],
        "foreign": foreign(path),
        "newer MCAP": b"\x89MCAP1\r\n" + flight[8:],
    }
    path.unlink()
    if kind in contents:
        path.write_bytes(contents[kind])
    before = sorted(tmp_path.iterdir())
    if command[0] == "perception":
        status = perception_main([str(path)])
    else:
        monkeypatch.setattr(sys, "argv", ["flightapp", *command, str(path)])
        with pytest.raises(SystemExit) as left:
            main()
        status = left.value.code
    said = capsys.readouterr().err.strip()
    assert status == 2
    assert words in said
    assert "x.mcap" in said
    assert "\n" not in said
    assert sorted(tmp_path.iterdir()) == before


def test_a_folder_in_place_of_a_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is a folder"):
        recover(tmp_path, tmp_path / "out.mcap")


def test_depth_frames_behind_a_damaged_chunk_are_played(tmp_path: Path) -> None:
    path = record(tmp_path / "p1.mcap", frames(6), history())
    data = path.read_bytes()
    chunks = chunks_of(data)
    _, end = chunks[len(chunks) // 2]
    path.write_bytes(data[: end - 20] + b"damaged" + data[end - 13 :])
    source = McapSource(path)
    numbers = []
    while (frame := source.latest()) is not None:
        numbers.append(frame.number)
    assert 3 <= len(numbers) < 6
    assert numbers[-1] == 105
    assert f"1 of {len(chunks)} chunks could not be read" in source.health.fault
    source.close()


def test_recover_tells_its_losses_as_json(
    tmp_path: Path, flight: bytes, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "p1.mcap"
    path.write_bytes(flight[: len(flight) // 2])
    monkeypatch.setattr(sys, "argv", ["flightapp", "recover", str(path), "--json"])
    with pytest.raises(SystemExit):
        main()
    told = json.loads(capsys.readouterr().out)
    assert told["complete"] is False
    assert "breaks off" in told["note"]

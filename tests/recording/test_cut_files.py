"""Recordings that were cut off, damaged, or never were recordings."""

from __future__ import annotations

import contextlib
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.writer import Writer

from flightapp.core.errors import InputError
from flightapp.recording.reader import read_recording
from flightapp.recording.recorder import Recorder
from flightapp.recording.recover import recover
from tests.recording.samples import log_steps

ROOT = Path(__file__).resolve().parents[2]
FREELY = settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("small") / "p1.mcap"
    with Recorder(path) as recorder:
        recorder.metadata("run", {"vehicle": "p1"})
        recorder.attach("mission.toml", ROOT / "missions" / "demo_two_pursuers.toml")
        log_steps(recorder, 20)
    return path


def read_and_recover(folder: Path, content: bytes) -> None:
    """Whatever the file holds, reading it answers or says in one sentence what is wrong."""
    path, output = folder / "p1.mcap", folder / "out.mcap"
    path.write_bytes(content)
    output.unlink(missing_ok=True)
    with contextlib.suppress(InputError):
        read_recording(path)
        recover(path, output)
        assert read_recording(output).complete
    assert path.read_bytes() == content
    assert {entry.name for entry in folder.iterdir()} <= {"p1.mcap", "out.mcap"}


def test_sigkill_loses_at_most_half_a_second(tmp_path: Path) -> None:
    path, output = tmp_path / "p1.mcap", tmp_path / "recovered.mcap"
    command = [sys.executable, "-m", "tests.recording.writer_process", str(path)]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        logged = [float(process.stdout.readline()) for _ in range(120)]
        process.kill()
        logged += [float(line) for line in process.stdout.read().splitlines()]
    recording = read_recording(path)
    assert not recording.complete
    assert recording.vehicle == "p1"
    times = recording.topic("/own").t_s
    assert logged[-1] - 0.5 <= times[-1] <= logged[-1] + 0.1
    assert len(times) == sum(t_s <= times[-1] + 1e-6 for t_s in logged)  # nothing is missing before the cut

    before = path.read_bytes()
    recovery = recover(path, output)
    assert path.read_bytes() == before
    assert not recovery.was_complete
    with output.open("rb") as file:
        messages = [message for _, channel, message in make_reader(file).iter_messages(topics=["/own"])]
    assert len(messages) == len(times)
    recovered = read_recording(output)
    assert recovered.complete
    assert recovered.topic("/own").messages == recording.topic("/own").messages


def test_recovery_overwrites_nothing(tmp_path: Path, small: Path) -> None:
    path, other = tmp_path / "p1.mcap", tmp_path / "other.mcap"
    path.write_bytes(small.read_bytes())
    other.write_bytes(b"precious")
    for output in (path, other):
        with pytest.raises(InputError, match="exists already"):
            recover(path, output)
    assert path.read_bytes() == small.read_bytes()
    assert other.read_bytes() == b"precious"


def test_recovery_into_a_missing_folder_is_one_sentence(tmp_path: Path, small: Path) -> None:
    path = tmp_path / "p1.mcap"
    path.write_bytes(small.read_bytes())
    with pytest.raises(InputError, match="cannot be written"):
        recover(path, tmp_path / "none" / "out.mcap")


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"", "the file is empty"),
        (b"\x00" * 4000, "does not begin like an MCAP file"),
        (b"\x89MCAP0\r\n", "broke off before its first record"),
        (b"# a text file", "does not begin like an MCAP file"),
    ],
)
def test_files_that_are_no_recordings(tmp_path: Path, content: bytes, sentence: str) -> None:
    (tmp_path / "x.mcap").write_bytes(content)
    with pytest.raises(InputError, match=sentence):
        read_recording(tmp_path / "x.mcap")


def test_a_foreign_mcap_file_is_named_as_such(tmp_path: Path) -> None:
    with (tmp_path / "x.mcap").open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2")
        writer.finish()  # type: ignore[no-untyped-call]
    with pytest.raises(InputError, match="not a recording of this application"):
        read_recording(tmp_path / "x.mcap")


def test_missing_files_and_folders_are_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_recording(tmp_path / "none.mcap")
    with pytest.raises(InputError, match="is a folder"):
        read_recording(tmp_path)


@FREELY
@given(share=st.floats(0.0, 1.0))
def test_truncation_anywhere(tmp_path: Path, small: Path, share: float) -> None:
    read_and_recover(tmp_path, small.read_bytes()[: int(share * small.stat().st_size)])


@FREELY
@given(data=st.data())
def test_damage_anywhere(tmp_path: Path, small: Path, data: st.DataObject) -> None:
    damaged = bytearray(small.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        start = data.draw(st.integers(0, len(damaged) - 1))
        damaged[start : start + data.draw(st.integers(0, 8))] = data.draw(st.binary(max_size=8))
    read_and_recover(tmp_path, bytes(damaged))


@FREELY
@given(content=st.binary(max_size=200))
def test_garbage_after_the_magic(tmp_path: Path, content: bytes) -> None:
    read_and_recover(tmp_path, b"\x89MCAP0\r\n" + content)

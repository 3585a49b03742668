"""What a power cut leaves: only what was synchronised. Told from the file's size at each fsync."""

from __future__ import annotations

import itertools
import os
import time
from pathlib import Path

import pytest

from flightapp.config.profile import RecordingOptions
from flightapp.recording import sink
from flightapp.recording.reader import read_recording
from flightapp.recording.recorder import Recorder
from flightapp.recording.recover import recover
from tests.recording.samples import T0_S, own

CUTS = 5


def test_everything_up_to_the_flush_before_is_on_the_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "p1.mcap"
    synchronised: list[tuple[int, int]] = []
    logged = 0

    def note(number: int) -> None:
        synchronised.append((os.fstat(number).st_size, logged))

    monkeypatch.setattr(sink.os, "fsync", note)
    options = RecordingOptions()
    assert options.flush_period_s <= 0.25  # two of them: half a second
    with Recorder(path, options=options) as recorder:
        deadline_s = time.monotonic() + 30.0
        while len(synchronised) <= CUTS:
            assert time.monotonic() < deadline_s
            t_s = T0_S + logged * 0.001
            recorder.log("/own", own(t_s, float(logged)), t_s)
            logged += 1
            time.sleep(0.001)
    whole = path.read_bytes()
    for (_, logged_before), (size, _) in itertools.pairwise(synchronised[: CUTS + 1]):
        cut, recovered = tmp_path / f"{size}.mcap", tmp_path / f"{size}-recovered.mcap"
        cut.write_bytes(whole[:size])
        assert not recover(cut, recovered).was_complete
        kept = read_recording(recovered).topic("/own").vectors("position_ned_m")[:, 0]
        assert kept.tolist() == list(range(len(kept)))  # no gap
        assert len(kept) >= logged_before > 0

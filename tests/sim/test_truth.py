"""The shared true state: what was written is read, also while the writer is in the middle of a write."""

import struct
from pathlib import Path

from flightapp.sim.truth import Truth, TruthReader, TruthWriter


def truth_at(monotonic_ns: int) -> Truth:
    return Truth(monotonic_ns, (1.0, 2.0, -3.0), (0.1, 0.2, 0.3), 0.01, -0.02, 1.5, True, False)


def test_the_newest_state_is_read_and_nothing_before_the_first(tmp_path: Path) -> None:
    path = tmp_path / "truth"
    writer = TruthWriter(path)
    reader = TruthReader(path)
    assert reader.read() is None
    for stamp in (5, 6, 7):
        writer.write(truth_at(stamp))
    assert reader.read() == truth_at(7)


def test_a_torn_write_gives_the_last_good_state(tmp_path: Path) -> None:
    path = tmp_path / "truth"
    writer = TruthWriter(path)
    reader = TruthReader(path)
    writer.write(truth_at(5))
    assert reader.read() == truth_at(5)
    with path.open("r+b") as file:  # an odd sequence number: the writer stopped half-way
        file.write(struct.pack("<Q", 3))
        file.write(struct.pack("<q", 6))
    assert reader.read() == truth_at(5)

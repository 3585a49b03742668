"""Damaged recordings by the thousand for everything that reads them: `python -m tests.recording.fuzz_reader --mutations 100000`.

Each file is read, recovered, loaded for the report and played to perception. Good is: read, or refused in one sentence that names
the file, within `LIMIT_CPU_S` and `LIMIT_MEMORY_BYTES`. Everything else is a finding, kept in the folder `--keep`.
"""

from __future__ import annotations

import argparse
import random
import resource
import signal
import sys
import tempfile
import traceback
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from mcap.reader import make_reader

from flightapp.analysis.run import load_run
from flightapp.core.errors import InputError
from flightapp.recording.reader import read_recording
from flightapp.recording.recover import recover
from perception.errors import PerceptionInputError
from perception.sources.mcap import McapSource
from tests.recording.mutations import base_files, mutated

LIMIT_CPU_S = 5.0
LIMIT_MEMORY_BYTES = 1 << 30
_SENTENCE_MAX = 600


class Overtime(BaseException):  # no Exception: nobody on the way may swallow it
    """The time for one file is over."""


@dataclass(slots=True)
class Outcomes:
    """How often each (consumer, mutation) ended how, and the findings: (file's number, consumer, what happened)."""

    counts: Counter[tuple[str, str, str]] = field(default_factory=Counter)
    findings: list[tuple[int, str, str]] = field(default_factory=list)


def read(path: Path) -> str:
    recording = read_recording(path)
    for series in recording.series.values():
        series.column("t_s"), series.vectors("position_ned_m"), series.texts("phase"), list(series.messages)
    return "read" if recording.complete else "salvaged"


def recovered(path: Path) -> str:
    output = path.with_name("recovered.mcap")
    try:
        found = recover(path, output)
        with output.open("rb") as file:
            summary = make_reader(file).get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == found.messages, f"{found.messages} messages recovered, not all in the file"
        return "read" if found.was_complete else "salvaged"
    finally:
        output.unlink(missing_ok=True)
        left = {entry.name for entry in path.parent.iterdir()} - {path.name}
        assert not left, f"files are left over: {left}"


def loaded(path: Path) -> str:
    return "read" if all(recording.complete for recording in load_run([path]).recordings) else "salvaged"


def played(path: Path) -> str:
    source = McapSource(path)
    amiss = False
    while source.latest() is not None:
        amiss = amiss or bool(source.health.fault)
    amiss = amiss or bool(source.health.fault)
    source.close()
    return "salvaged" if amiss else "read"


CONSUMERS: dict[str, Callable[[Path], str]] = {"read": read, "recover": recovered, "report": loaded, "perception": played}


def fuzz(mutations: int, seed: int, folder: Path, keep: Path | None = None) -> Outcomes:
    """Feed `mutations` damaged files to every consumer. `folder`: an empty one to write them to."""
    bases = base_files()
    outcomes = Outcomes()
    path = folder / "p1.mcap"
    limit_memory()
    signal.signal(signal.SIGVTALRM, _over)
    for number in range(mutations):
        chance = random.Random(f"{seed}/{number}")  # every file by itself, so that one finding can be repeated alone
        name, data = mutated(chance, chance.choice(bases), chance.choice(bases))
        path.write_bytes(data)
        for consumer, consume in CONSUMERS.items():
            outcome = outcome_of(consume, path)
            kind = outcome if outcome in ("read", "salvaged", "refused") else "FINDING"
            outcomes.counts[consumer, name, kind] += 1
            if kind == "FINDING":
                outcomes.findings.append((number, consumer, outcome))
                if keep is not None:
                    (keep / f"{number}-{consumer}.mcap").write_bytes(data)
    return outcomes


def outcome_of(consume: Callable[[Path], str], path: Path) -> str:
    """`read`, `salvaged`, `refused`, or what went wrong."""
    signal.setitimer(signal.ITIMER_VIRTUAL, LIMIT_CPU_S)
    try:
        return consume(path)
    except (InputError, PerceptionInputError) as error:
        text = str(error)
        if not all(path.name in line and len(line) < _SENTENCE_MAX for line in text.split("\n")):
            return f"not one sentence for each thing that is wrong: {text!r}"
        return "refused"
    except Overtime:
        return f"more than {LIMIT_CPU_S} s of CPU"
    except BaseException:
        return traceback.format_exc(limit=-4)
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)


def limit_memory() -> None:
    """This process may grow by so much and no more: whoever asks for more gets a MemoryError."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + LIMIT_MEMORY_BYTES, hard))


def table(outcomes: Outcomes) -> str:
    kinds = ("read", "salvaged", "refused", "FINDING")
    lines = [f"{'':30}{''.join(f'{kind:>10}' for kind in kinds)}"]
    for place in (0, 1):
        for row in sorted({key[place] for key in outcomes.counts}):
            counts = [sum(n for key, n in outcomes.counts.items() if key[place] == row and key[2] == kind) for kind in kinds]
            lines.append(f"{row:30}{''.join(f'{count:10}' for count in counts)}")
        lines.append("")
    return "\n".join(lines)


def _over(number: int, frame: object) -> None:
    raise Overtime


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mutations", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="Folder for the files that were findings.")
    arguments = parser.parse_args()
    if arguments.keep is not None:
        arguments.keep.mkdir(parents=True, exist_ok=True)
    memory = Path("/dev/shm")  # files that are gone at once need no disk
    with tempfile.TemporaryDirectory(dir=memory if memory.is_dir() else None) as folder:
        outcomes = fuzz(arguments.mutations, arguments.seed, Path(folder), arguments.keep)
    used = resource.getrusage(resource.RUSAGE_SELF)
    sys.stdout.write(table(outcomes))
    sys.stdout.write(f"{arguments.mutations} files, {used.ru_utime + used.ru_stime:.0f} s of CPU, {used.ru_maxrss // 1024} MiB\n")
    for number, consumer, what in outcomes.findings[:20]:
        sys.stdout.write(f"\nfile {number}, {consumer}:\n{what}\n")
    return 1 if outcomes.findings else 0


if __name__ == "__main__":
    sys.exit(main())

"""The evaluations so far as JSON lines: first what is optimised, then one line an evaluation. Always whole on the disk."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from flightapp.analysis.summary import write_whole
from flightapp.analysis.tuning.optimiser import Sample
from flightapp.core.errors import InputError


@dataclass(frozen=True, slots=True)
class Evaluation:
    """One batch: where in the square, and what it came to."""

    x1: float
    x2: float
    j: float
    success_rate: float

    def sample(self) -> Sample:
        return Sample(self.x1, self.x2, self.j)


@dataclass(slots=True)
class Checkpoint:
    """What is optimised (plain JSON values), and the evaluations of it."""

    path: Path
    problem: dict[str, Any]
    evaluations: list[Evaluation]

    def add(self, evaluation: Evaluation) -> None:
        """Keep one more evaluation, on the disk before this returns."""
        self.evaluations.append(evaluation)
        self.write()

    def write(self) -> None:
        lines = [json.dumps(self.problem), *(json.dumps(asdict(one)) for one in self.evaluations)]
        write_whole(self.path, ("\n".join(lines) + "\n").encode())


def begin(path: Path, problem: dict[str, Any]) -> Checkpoint:
    """A new checkpoint; InputError if there is one already."""
    if path.exists():
        raise InputError(f"{path}: exists already; go on with --resume, or name another --output")
    checkpoint = Checkpoint(path, problem, [])
    checkpoint.write()
    return checkpoint


def resume(path: Path, problem: dict[str, Any]) -> Checkpoint:
    """The checkpoint in `path`; InputError if there is none, or if it is of another problem."""
    try:
        lines = path.read_text().splitlines()
        found = json.loads(lines[0])
        evaluations = [Evaluation(**json.loads(line)) for line in lines[1:]]
    except FileNotFoundError:
        raise InputError(f"{path}: no such checkpoint; leave --resume out to begin") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except (ValueError, TypeError, IndexError):
        raise InputError(f"{path}: not a checkpoint of flightapp tune; name another --output") from None
    for key, value in problem.items():
        if found.get(key) != value:
            raise InputError(f"{path}: is a checkpoint of another {key}; resume with the same command, or name another --output")
    return Checkpoint(path, problem, evaluations)

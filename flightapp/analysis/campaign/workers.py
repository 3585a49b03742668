"""Where runs are flown: the cores of this machine, or a Dask or Ray cluster. The scheduling is joblib's."""

from __future__ import annotations

import importlib
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import joblib

from flightapp.core.errors import InputError

BACKENDS = ("local", "dask", "ray")
_RAY_TASKS_A_WORKER = 4


@dataclass(frozen=True, slots=True)
class Workers:
    """`count` None: all local cores, or all that the cluster has."""

    count: int | None = None
    backend: str = "local"

    def __post_init__(self) -> None:
        if self.count is not None and self.count < 1:
            raise InputError(f"--workers {self.count}: must be at least 1")
        if self.backend not in BACKENDS:
            raise InputError(f"--backend {self.backend}: no such backend; known: {', '.join(BACKENDS)}")

    @property
    def expected(self) -> int:
        """How many runs are expected to be in flight together."""
        return int(joblib.cpu_count()) if self.count is None else self.count


def flown(workers: Workers, tasks: Sequence[Any]) -> Iterator[Any]:
    """Results of joblib tasks in the processes of `workers`, one thread each, as they come.

    Dask: the cluster that DASK_SCHEDULER_ADDRESS names; Ray: that of RAY_ADDRESS; without these, one on this machine.
    """
    n_jobs = -1 if workers.count is None else workers.count
    with _backend(workers) as options, joblib.parallel_config(**options):
        if workers.backend != "ray":
            yield from joblib.Parallel(n_jobs=n_jobs, return_as="generator_unordered")(tasks)
            return
        parallel = joblib.Parallel(n_jobs=n_jobs)  # Ray's joblib backend only returns whole lists: so in rounds
        size = _RAY_TASKS_A_WORKER * joblib.effective_n_jobs(n_jobs)
        for start in range(0, len(tasks), size):
            yield from parallel(tasks[start : start + size])


@contextmanager
def _backend(workers: Workers) -> Iterator[dict[str, Any]]:
    if workers.backend == "local":
        yield {"backend": "loky", "inner_max_num_threads": 1}
    elif workers.backend == "dask":
        distributed = _imported("distributed", "dask")
        own = {} if "DASK_SCHEDULER_ADDRESS" in os.environ else {"n_workers": workers.count, "threads_per_worker": 1}
        with distributed.Client(**own):
            yield {"backend": "dask"}
    else:
        ray, ray_joblib = _imported("ray", "ray"), _imported("ray.util.joblib", "ray")
        own = {} if "RAY_ADDRESS" in os.environ else {"num_cpus": workers.count}
        ray.init(log_to_driver=False, **own)
        ray_joblib.register_ray()
        try:
            yield {"backend": "ray"}
        finally:
            ray.shutdown()


def _imported(module: str, extra: str) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError:
        wanted = f"pip install 'flightapp[{extra}]'"
        raise InputError(f"--backend {extra}: {module} is not installed; install the extra: {wanted}") from None

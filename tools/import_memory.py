"""What a vehicle process keeps in memory before it flies, by package: which import costs what.

    .venv/bin/python tools/import_memory.py

Resident memory that each module added while it was loaded, without what it loaded itself; packages of flightapp by two levels.
Kernels that numba has cached are loaded with their module and count there; the first of them also starts LLVM.
"""

from __future__ import annotations

import importlib._bootstrap as bootstrap
import sys
from collections import defaultdict
from typing import Any

import psutil

SHOWN = 14
MODULE = "flightapp.runtime.vehicle_process"


def main() -> None:
    process, own_mb, inner_mb = psutil.Process(), defaultdict[str, float](float), [0.0]
    load = bootstrap._load_unlocked

    def measured(spec: Any) -> Any:
        before_mb = process.memory_info().rss / 1e6
        inner_mb.append(0.0)
        try:
            return load(spec)
        finally:
            added_mb = process.memory_info().rss / 1e6 - before_mb
            own_mb[package_of(spec.name)] += added_mb - inner_mb.pop()
            inner_mb[-1] += added_mb

    bootstrap._load_unlocked = measured
    __import__(MODULE)
    print(f"{process.memory_info().rss / 1e6:6.0f} MB after importing {MODULE}: {len(sys.modules)} modules")
    for name, mb in sorted(own_mb.items(), key=lambda one: -one[1])[:SHOWN]:
        print(f"{mb:6.1f} MB  {name}")


def package_of(module: str) -> str:
    parts = module.split(".")
    return ".".join(parts[:2]) if parts[0] in ("flightapp", "perception") else parts[0]


if __name__ == "__main__":
    main()

"""A kernel in the cache is fresh only as long as everything that went into it is."""

from __future__ import annotations

import importlib.util
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

from flightapp import warm_up
from perception import kernel_cache

INNER = """
from flightapp.core.compiled import compiled

GAIN = 2.0

@compiled("f8(f8)")
def inner(x):
    return {expression}
"""
OUTER = """
from flightapp.core.compiled import compiled
from inner_kernels import inner

@compiled("f8(f8)")
def outer(x):
    return inner(x) + 1.0
"""


def load(folder: Path, name: str) -> ModuleType:
    specification = importlib.util.spec_from_file_location(name, folder / f"{name}.py")
    assert specification is not None
    assert specification.loader is not None
    module = sys.modules[name] = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def outer_of(folder: Path, expression: str) -> ModuleType:
    """The outer kernel as a new process would load it."""
    (folder / "inner_kernels.py").write_text(INNER.format(expression=expression))
    kernel_cache.source_stamp.cache_clear()
    kernel_cache._file_stamp.cache_clear()
    load(folder, "inner_kernels")
    return load(folder, "outer_kernels")


def test_a_changed_callee_in_another_file_is_compiled_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "inner_kernels", raising=False)
    monkeypatch.delitem(sys.modules, "outer_kernels", raising=False)
    (tmp_path / "outer_kernels.py").write_text(OUTER)
    first = outer_of(tmp_path, "GAIN * x")
    again = outer_of(tmp_path, "GAIN * x")
    changed = outer_of(tmp_path, "GAIN * x * x")
    assert [module.outer(3.0) for module in (first, again, changed)] == [7.0, 7.0, 19.0]
    hits = [sum(module.outer.stats.cache_hits.values()) for module in (first, again, changed)]
    assert hits == [0, 1, 0]


def test_every_kernel_is_made_by_the_one_rule_of_freshness() -> None:
    """A kernel under numba's own rule was compiled anew whenever a process imported the packages in another order."""
    root = Path(__file__).parents[2]
    elsewhere = [
        str(file.relative_to(root))
        for package in ("flightapp", "perception")
        for file in (root / package).rglob("*.py")
        if re.search(r"numba\.(njit|jit|vectorize|guvectorize)\b|from numba import [^\n]*jit", file.read_text())
    ]
    assert elsewhere == ["perception/kernel_cache.py"]


def test_installation_compiles_every_kernel() -> None:
    """What it does not reach would be compiled in a vehicle's process, at the field."""
    root = Path(__file__).parents[2]
    with_kernels = {
        ".".join(file.relative_to(root).with_suffix("").parts)
        for package in ("flightapp", "perception")
        for file in (root / package).rglob("*.py")
        if re.search(r"^@(njit|compiled)\b", file.read_text(), re.MULTILINE)
    }
    names = (*warm_up.PARTS, *warm_up.WHOLE)
    program = f"import importlib, sys\nfor name in {names}: importlib.import_module(name)\nprint(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout.split()
    assert with_kernels - set(loaded) == set()

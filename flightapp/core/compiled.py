"""The one way in which this package compiles a kernel: explicit signature, at import, cached.

A call with another dtype or memory layout raises TypeError instead of compiling in flight. Floating point stays strict, so
the same inputs give the same bits. The interpreter lock is kept: these kernels run for microseconds, and handing the lock over
with each of them costs more than it gives, up to a switch interval wherever another thread of the vehicle is busy.

A kernel in the cache contains the kernels that it calls. Numba takes it for fresh as long as its own file is the same; here it
is fresh as long as everything that went into it is.
"""

from __future__ import annotations

import functools
import hashlib
import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import numba
import numpy as np
from numba.core.caching import InTreeCacheLocator, UserProvidedCacheLocator, UserWideCacheLocator
from numba.core.dispatcher import Dispatcher

P = ParamSpec("P")
R = TypeVar("R")


def compiled(signature: object) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Decorator that compiles a function of floats, float64 arrays and records for `signature` (text or a numba type)."""

    def wrap(function: Callable[P, R]) -> Callable[P, R]:
        options = {"cache": True, "error_model": "numpy", "no_cfunc_wrapper": True}  # nothing calls them from C
        kernel: Callable[P, R] = numba.njit(signature, **options)(function)  # type: ignore[call-overload]
        return kernel

    return wrap


def inlined(function: Callable[P, R]) -> Callable[P, R]:
    """Decorator of a part of a kernel: compiled within what calls it, so that the compiler goes through its callees once less."""
    part: Callable[P, R] = numba.njit(inline="always", error_model="numpy")(function)
    return part


@functools.cache
def source_stamp(function: Callable[..., object]) -> str:
    """Changes with the file of `function`, the kernels that it calls, theirs, and the constants that all of them name."""
    parts = [_file_stamp(inspect.getfile(function))]
    names: dict[str, Any] = function.__globals__
    for name in sorted(set(function.__code__.co_names)):
        value = names.get(name)
        if isinstance(value, Dispatcher):
            parts.append(source_stamp(value.py_func))
        elif isinstance(value, int | float | str | tuple | np.dtype):
            parts.append(f"{name}={value!r}")
        elif isinstance(value, type):
            parts.append(f"{name}: {getattr(value, '_fields', ())}")
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


@functools.cache
def _file_stamp(path: str) -> str:
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


class _Stamped:
    """A place for the cache, with `source_stamp` for its freshness."""

    def __init__(self, function: Callable[..., object], path: str) -> None:
        super().__init__(function, path)  # type: ignore[call-arg]
        self._function = function

    def get_source_stamp(self) -> str:
        return source_stamp(self._function)


class InTheGivenFolder(_Stamped, UserProvidedCacheLocator):
    """Where NUMBA_CACHE_DIR says, if it says so."""


class BesideTheSource(_Stamped, InTreeCacheLocator):
    """In the folder of the source file."""


class InTheUsersFolder(_Stamped, UserWideCacheLocator):
    """In the user's cache, where the source's folder cannot be written."""


PLACES = (InTheGivenFolder, BesideTheSource, InTheUsersFolder)
vars(numba.config)["CACHE_LOCATOR_CLASSES"] = ",".join(f"{__name__}.{place.__name__}" for place in PLACES)

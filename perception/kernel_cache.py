"""Where numba keeps compiled kernels, and until when they are fresh. Every kernel of both packages is made with `njit` from here.

A kernel in the cache contains the kernels that it calls. Numba takes it for fresh as long as its own file is the same; here it
is fresh as long as everything that went into it is. The rule must hold in every process alike: a process with numba's own rule
would take all kernels of one with this rule for stale, and compile them anew.
"""

from __future__ import annotations

import functools
import hashlib
import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numba.core.caching import InTreeCacheLocator, UserProvidedCacheLocator, UserWideCacheLocator
from numba.core.dispatcher import Dispatcher

njit = numba.njit


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

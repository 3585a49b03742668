"""The one way in which this package compiles a kernel: explicit signature, at import, cached.

A call with another dtype or memory layout raises TypeError instead of compiling in flight. Floating point stays strict, so
the same inputs give the same bits. The interpreter lock is kept: these kernels run for microseconds, and handing the lock over
with each of them costs more than it gives, up to a switch interval wherever another thread of the vehicle is busy.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar

from perception.kernel_cache import njit

P = ParamSpec("P")
R = TypeVar("R")


def compiled(signature: object) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Decorator that compiles a function of floats, float64 arrays and records for `signature` (text or a numba type)."""

    def wrap(function: Callable[P, R]) -> Callable[P, R]:
        options = {"cache": True, "error_model": "numpy", "no_cfunc_wrapper": True}  # nothing calls them from C
        kernel: Callable[P, R] = njit(signature, **options)(function)  # type: ignore[call-overload]
        return kernel

    return wrap


def inlined(function: Callable[P, R]) -> Callable[P, R]:
    """Decorator of a part of a kernel: compiled within what calls it, so that the compiler goes through its callees once less."""
    part: Callable[P, R] = njit(inline="always", error_model="numpy")(function)
    return part

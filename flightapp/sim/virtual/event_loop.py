"""An asyncio event loop whose time jumps: nothing is waited for, what is due next happens now."""

from __future__ import annotations

import asyncio
import selectors
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from typing import Any, TypeVar, TypeVarTuple

R = TypeVar("R")
Ts = TypeVarTuple("Ts")
START_S = 1_000.0
THREAD_S = 0.2
"""How long whatever is given to a thread takes."""


class StandstillError(RuntimeError):
    """Every task waits for something that no task will ever do."""


class _Selector(selectors.BaseSelector):
    """Instead of sleeping until a deadline it moves the clock there."""

    def __init__(self) -> None:
        self._real = selectors.DefaultSelector()
        self.now_s = START_S

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        if timeout is None:
            raise StandstillError("no timer is set and no task can go on")
        self.now_s += max(timeout, 0.0)
        return self._real.select(0)

    def register(self, fileobj: Any, events: int, data: Any = None) -> selectors.SelectorKey:
        return self._real.register(fileobj, events, data)

    def unregister(self, fileobj: Any) -> selectors.SelectorKey:
        return self._real.unregister(fileobj)

    def close(self) -> None:
        self._real.close()

    def get_map(self) -> Mapping[Any, selectors.SelectorKey]:
        return self._real.get_map()


class VirtualEventLoop(asyncio.SelectorEventLoop):
    """Time is virtual; for code that uses neither threads nor sockets to make progress."""

    def __init__(self) -> None:
        self._virtual = _Selector()
        super().__init__(self._virtual)

    def time(self) -> float:
        return self._virtual.now_s

    def run_in_executor(self, executor: Executor | None, func: Callable[[*Ts], R], *args: *Ts) -> asyncio.Future[R]:  # noqa: ARG002
        """What a thread would compute is computed now and known THREAD_S later: everybody else goes on meanwhile."""
        known: asyncio.Future[R] = self.create_future()
        result = func(*args)
        self.call_later(THREAD_S, lambda: None if known.done() else known.set_result(result))
        return known

    def spend(self, duration_s: float) -> None:
        """Time passes while a callback runs: a computation that takes long."""
        self._virtual.now_s += duration_s


class VirtualClock:
    """The loop's time as fleet time, as one computer knows it: `offset_s` is what its clock is ahead of the others'."""

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self._loop = loop
        self.offset_s = 0.0

    def now_s(self) -> float:
        return self._loop.time() + self.offset_s

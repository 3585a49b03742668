"""PX4 parameters, read and written on the ground only: each call blocks a thread of the default pool until it is answered."""

from __future__ import annotations

import asyncio
from typing import Any

import mavsdk
from mavsdk.plugins.param import Param

from flightapp.core.errors import FlightError

UNKNOWN = ("TIMEOUT", "DOES_NOT_EXIST", "NOT_FOUND", "PARAM_NOT_FOUND", "DOESNT_EXIST")
"""PX4 before 1.16 does not answer at all when asked for a parameter that it does not have."""


class Parameters:
    """Of one connected autopilot."""

    def __init__(self, system: Any) -> None:
        self._param = Param(system)

    async def read(self, name: str, *, is_integer: bool) -> float | None:
        """The value; None where this autopilot has no such parameter. FlightError where it answers something else."""
        get = self._param.get_param_int if is_integer else self._param.get_param_float
        try:
            return float(await asyncio.to_thread(get, name))
        except mavsdk.MavsdkError as error:
            result = _result(error)
            if result in UNKNOWN:
                return None
            raise FlightError(f"parameter {name}: {result}") from None

    async def write(self, name: str, value: float, *, is_integer: bool) -> None:
        try:
            if is_integer:
                await asyncio.to_thread(self._param.set_param_int, name, int(value))
            else:
                await asyncio.to_thread(self._param.set_param_float, name, value)
        except mavsdk.MavsdkError as error:
            raise FlightError(f"parameter {name}: {_result(error)}") from None


def _result(error: mavsdk.MavsdkError) -> str:
    return str(getattr(getattr(error, "result", None), "name", error))

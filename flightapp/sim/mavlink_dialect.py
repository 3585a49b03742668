"""The MAVLink 2 dialect that the mock speaks; the module of pymavlink has no type stubs, hence Any."""

from __future__ import annotations

from typing import Any

from pymavlink.dialects.v20 import common

mavlink: Any = common
Message = Any

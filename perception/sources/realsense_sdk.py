"""The RealSense SDK, imported when a source is made: without a camera nobody needs it."""

from __future__ import annotations

from typing import Any

from perception.errors import PerceptionInputError


def import_sdk() -> Any:
    """The module pyrealsense2; PerceptionInputError, which says what to install, where it cannot be imported."""
    try:
        import pyrealsense2
    except ImportError as error:
        raise PerceptionInputError(
            f"pyrealsense2 cannot be imported ({error}); install the extra 'realsense' and the system library libusb-1.0-0"
        ) from None
    return pyrealsense2

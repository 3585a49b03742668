"""Which RealSense device: a camera by its serial number, or a recording of one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from perception.errors import PerceptionInputError


class CameraFinder:
    """Finds one camera, and the same one again after it was unplugged.

    Without a serial number it takes the only camera there is. PerceptionInputError if there is none, or more to choose from.
    """

    def __init__(self, rs: Any, serial_number: str | None) -> None:
        self._rs = rs
        self._context = rs.context()
        self._serial_number = serial_number

    def __call__(self) -> Any:
        device = choose_camera(connected_cameras(self._rs, self._context), self._serial_number)
        self._serial_number = device.get_info(self._rs.camera_info.serial_number)
        return device


def connected_cameras(rs: Any, context: Any) -> dict[str, Any]:
    """Devices by serial number; those that go away while being asked are left out."""
    try:
        devices = list(context.query_devices())
    except RuntimeError as error:
        raise PerceptionInputError(f"RealSense cameras cannot be listed ({one_line(error)}); check the udev rules") from None
    cameras = {}
    for device in devices:
        try:
            cameras[device.get_info(rs.camera_info.serial_number)] = device
        except RuntimeError:
            continue
    return cameras


def choose_camera(cameras: dict[str, Any], serial_number: str | None) -> Any:
    """One of `cameras`; PerceptionInputError, with the serial numbers that are there, if that is not clear."""
    there = ", ".join(sorted(cameras))
    if serial_number is None:
        if len(cameras) > 1:
            raise PerceptionInputError(f"several RealSense cameras are connected; name one by its serial number: {there}")
        if not cameras:
            raise PerceptionInputError("no RealSense camera is connected; check its cable and the udev rules")
        return next(iter(cameras.values()))
    if serial_number not in cameras:
        found = f"connected are: {there}" if cameras else "none is connected; check its cable and the udev rules"
        raise PerceptionInputError(f"RealSense camera {serial_number} is not there; {found}")
    return cameras[serial_number]


def load_recording(rs: Any, path: Path, *, is_real_time: bool) -> Any:
    """The playback device of a `.db3` or older `.bag` file; PerceptionInputError if it is missing, cut short or foreign."""
    if not path.is_file():
        raise PerceptionInputError(f"{path}: no such recording; a .db3 or .bag file of the RealSense SDK is wanted")
    if path.suffix.lower() not in (".db3", ".bag"):
        raise PerceptionInputError(f"{path}: not a recording of the RealSense SDK; a .db3 or .bag file is wanted")
    try:
        playback = rs.context().load_device(str(path))
        playback.set_real_time(is_real_time)
    except RuntimeError as error:
        raise PerceptionInputError(
            f"{path}: not a whole recording of the RealSense SDK ({one_line(error)}); record it again or copy it whole"
        ) from None
    return playback


def label(rs: Any, device: Any) -> str:
    """What sentences call the device, for example `Intel RealSense D435 (934222071234)`."""
    name = _info(device, rs.camera_info.name) or "RealSense camera"
    serial_number = _info(device, rs.camera_info.serial_number)
    return f"{name} ({serial_number})" if serial_number else name


def usb_warning(rs: Any, device: Any) -> str:
    """A sentence if the camera hangs on USB 2, else empty."""
    usb = _info(device, rs.camera_info.usb_type_descriptor)
    if not usb.startswith(("1", "2")):
        return ""
    return f"{label(rs, device)} is connected by USB {usb}: few modes, frames may be lost; use a USB 3 port and cable"


def _info(device: Any, kind: Any) -> str:
    try:
        return str(device.get_info(kind)) if device.supports(kind) else ""
    except RuntimeError:
        return ""


def one_line(error: Exception) -> str:
    """The SDK's message, which may have several."""
    return " ".join(str(error).split())

"""Where depth frames come from; every source is one small file behind `DepthSource`, `opening` has the list."""

from perception.sources.api import DepthSource, SourceHealth
from perception.sources.opening import SourceOptions, open_source
from perception.sources.png_folder import PngFolderSource
from perception.sources.realsense import RealSenseSource, open_camera
from perception.sources.realsense_recording import RealSenseRecordingSource
from perception.sources.realsense_stream import DepthMode
from perception.sources.shared_memory import SharedMemorySource, SharedMemoryWriter

__all__ = [
    "DepthMode",
    "DepthSource",
    "PngFolderSource",
    "RealSenseRecordingSource",
    "RealSenseSource",
    "SharedMemorySource",
    "SharedMemoryWriter",
    "SourceHealth",
    "SourceOptions",
    "open_camera",
    "open_source",
]

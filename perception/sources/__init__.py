"""Where depth frames come from; every source is one small file behind `DepthSource`."""

from perception.sources.api import DepthSource, SourceHealth
from perception.sources.png_folder import PngFolderSource
from perception.sources.realsense import RealSenseSource
from perception.sources.shared_memory import SharedMemorySource, SharedMemoryWriter

__all__ = ["DepthSource", "PngFolderSource", "RealSenseSource", "SharedMemorySource", "SharedMemoryWriter", "SourceHealth"]

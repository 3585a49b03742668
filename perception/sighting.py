"""What one depth frame showed, in the mission frame: between extraction and tracking."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from perception.geometry import CameraPose


@dataclass(frozen=True, slots=True)
class View:
    """Where one frame looked and how far.

    seen: (360,) half-degree sectors ahead that were seen. nearest_m: forward distance of the first surface in each bearing bin
    (perception.extraction.bearing_bins), inf where there is none. furthest_m: forward distance in each bearing bin up to which
    lines of sight within the height band were followed by returns from there or beyond, 0 where nothing returned: what was
    known to stand nearer than that is gone. Returns from beyond `reliable_range_m` count up to it.
    reliable_range_m: depth up to which a surface in a seen sector would have been found.
    """

    camera: CameraPose
    seen: NDArray[np.bool_]
    nearest_m: NDArray[np.float64]
    furthest_m: NDArray[np.float64]
    range_min_m: float
    reliable_range_m: float


@dataclass(frozen=True, slots=True)
class Sighting:
    """Discs of one frame and its view.

    discs: (m, 3) north_m, east_m, radius_m. sigma_m: (m,) standard deviation of the position along the line of sight.
    confidence: (m,) in [0, 1]. is_whole: (m,) one disc stands for one whole object, not cut off by the edge of the picture, the
    range limit, a hidden sector or something nearer: only then a change of its place means that it moved.
    """

    discs: NDArray[np.float64]
    sigma_m: NDArray[np.float64]
    confidence: NDArray[np.float64]
    is_whole: NDArray[np.bool_]
    view: View

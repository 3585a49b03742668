"""What GPS says of the log's clock: a check on the alignment that needs no motion."""

from __future__ import annotations

import numpy as np

from flightapp.analysis.ulog.log import FlightLog

FIX_3D = 3


def gps_offset_s(log: FlightLog) -> float | None:
    """Unix time at the start of the log, s; None without a fix. The receiver's own delay, some 0.1 s, is in it."""
    topic = log.topic("sensor_gps") or log.topic("vehicle_gps_position")
    utc, fix = (None, None) if topic is None else (topic.column("time_utc_usec"), topic.column("fix_type"))
    if topic is None or utc is None:
        return None
    good = (utc > 0) if fix is None else (utc > 0) & (fix >= FIX_3D)
    return float(np.median(utc[good] * 1e-6 - topic.t_s[good])) if good.any() else None

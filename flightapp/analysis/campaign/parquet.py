"""runs.parquet: one row a run. Columns and types are the same for every campaign; units stand in the names."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from flightapp.sim.batch.result import RunResult

SCHEMA = pa.schema(
    [
        pa.field("scenario", pa.string(), nullable=False),
        pa.field("planner", pa.string(), nullable=False),
        pa.field("seed", pa.int64(), nullable=False),
        pa.field("outcome", pa.string(), nullable=False),
        pa.field("collided_with", pa.string(), nullable=False),
        pa.field("duration_s", pa.float64(), nullable=False),
        pa.field("capture_time_s", pa.float64()),
        pa.field("path_length_m", pa.float64()),
        pa.field("mean_jerk_m_s3", pa.float64()),
        pa.field("boundary_distance_m", pa.float64()),
        pa.field("min_clearance_m", pa.float64()),
        pa.field("min_separation_m", pa.float64()),
        pa.field("shortest_path_m", pa.float64()),
        pa.field("mode_share", pa.map_(pa.string(), pa.float64()), nullable=False),
        pa.field("decisions", pa.int64(), nullable=False),
        pa.field("decision_p50_us", pa.float64()),
        pa.field("decision_p99_us", pa.float64()),
        pa.field("decision_max_us", pa.float64()),
        pa.field("sim_wall_s", pa.float64(), nullable=False),
        pa.field("encircled_first_s", pa.float64()),
        pa.field("encircled_share", pa.float64()),
        pa.field("encircled_at_capture", pa.bool_()),
        pa.field("travel_m", pa.float64()),
        pa.field("turning_rad", pa.float64()),
        pa.field("lost", pa.int64(), nullable=False),
        pa.field("flag_share", pa.map_(pa.string(), pa.float64()), nullable=False),
    ]
)
TIMING_COLUMNS = ("decision_p50_us", "decision_p99_us", "decision_max_us", "sim_wall_s")
"""What differs when the same runs are flown again."""
_SAME = ("scenario", "planner", "seed", "outcome", "collided_with", "duration_s")
_TEAM = ("encircled_share", "travel_m", "turning_rad", "encircled_first_s")
_FINITE = tuple(name for name in SCHEMA.names[len(_SAME) : SCHEMA.names.index("mode_share")])


def runs_parquet(results: Sequence[RunResult]) -> bytes:
    """The file; infinite and unknown figures are null."""
    table = pa.Table.from_pylist([_row(result) for result in results], schema=SCHEMA)
    sink = io.BytesIO()
    pq.write_table(table, sink, compression="zstd")
    return sink.getvalue()


def _row(result: RunResult) -> dict[str, object]:
    microseconds = result.decision_ns * 1e-3
    p50, p99, most = np.percentile(microseconds, (50.0, 99.0, 100.0)).tolist() if len(microseconds) else (None, None, None)
    return {
        **{name: getattr(result, name) for name in _SAME},
        **{name: _finite(getattr(result, name)) for name in _FINITE},
        "mode_share": sorted(result.mode_share.items()),
        "decisions": result.decisions,
        "decision_p50_us": p50,
        "decision_p99_us": p99,
        "decision_max_us": most,
        "sim_wall_s": result.sim_wall_ns * 1e-9,
        **{name: _finite(getattr(result, name)) for name in _TEAM},
        "encircled_at_capture": result.encircled_at_capture,
        "lost": result.lost,
        "flag_share": sorted(result.flag_share.items()),
    }


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None

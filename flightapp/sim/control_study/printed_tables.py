"""Tables 1 and 2 of the source as printed, to stand beside ours (Yan, Liu, Hao, Drones 9(9):611, 2025)."""

from __future__ import annotations

from flightapp.sim.control_study.flown import Setting

NAMES = ("hybrid", "smc", "pid", "adrc")

SETTINGS = (
    Setting("step 2 m, 17 obstacles"),
    Setting("step 1 m", step_m=1.0),
    Setting("step 3 m", step_m=3.0),
    Setting("10 obstacles", obstacles=10),
    Setting("25 obstacles", obstacles=25),
)
"""Its 25 obstacles do not fit with 20 m between their centres: ours stand 16 m apart."""

TABLE_1 = {
    "step 2 m, 17 obstacles": ((99.85, 2.63, 5.32), (99.72, 3.28, 5.27), (98.62, 4.59, 5.19), (96.24, 7.98, 5.14)),
    "step 1 m": ((99.91, 2.45, 5.36), (99.78, 3.01, 5.33), (99.02, 4.32, 5.18), (97.15, 7.84, 5.22)),
    "step 3 m": ((99.67, 2.81, 5.24), (98.92, 3.65, 5.18), (97.41, 4.77, 5.09), (95.68, 8.45, 5.05)),
    "10 obstacles": ((99.94, 2.36, 5.42), (99.84, 2.97, 5.35), (99.11, 4.25, 5.15), (97.86, 7.72, 5.25)),
    "25 obstacles": ((99.61, 2.98, 5.18), (98.34, 3.79, 5.13), (96.83, 4.88, 5.06), (95.42, 8.61, 5.02)),
}
"""By setting, for each of NAMES: success in %, steady error in m, smallest separation in m."""

TABLE_2 = {
    "tracking mean, steady, max, std": (
        (3.0, 2.5, 6.0, 0.8),
        (3.5, 2.6, 11.5, 1.5),
        (7.8, 5.5, 15.0, 3.0),
        (8.3, 8.1, 15.0, 3.5),
    ),
    "spacing mean, min, max, std": ((6.7, 5.0, 9.5, 1.0), (7.5, 5.0, 11.5, 1.3), (14.5, 9.0, 19.0, 2.8), (8.8, 6.0, 15.0, 2.2)),
    "formation mean, max, std": ((3.0, 9.0, 1.2), (3.5, 12.0, 1.6), (10.0, 16.0, 3.5), (10.0, 21.0, 4.0)),
}
"""By metric, for each of NAMES, m."""

FIGURES_16_TO_18 = (
    "x, y error below 1 m; z 10 to 15 m at 2 to 5 s, then 2 m; |e| 5 m at 1 s, 0.2 to 0.5 m later; |s| 16, later 0.5 m/s; "
    "V from 10 to 0.01 in 5 s"
)

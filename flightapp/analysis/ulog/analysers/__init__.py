"""All analysers of PX4 logs, in the order of the report; a new one is one small file and one line here."""

from flightapp.analysis.ulog.analyser import Analyser
from flightapp.analysis.ulog.analysers import (
    battery,
    ending,
    estimator,
    failsafe,
    gps,
    link,
    magnetometer,
    messages,
    offboard,
    power,
    processor,
    tracking,
    vibration,
)

ANALYSERS: tuple[Analyser, ...] = tuple(
    module.ANALYSER
    for module in (
        ending,
        battery,
        power,
        gps,
        estimator,
        magnetometer,
        offboard,
        failsafe,
        link,
        messages,
        vibration,
        tracking,
        processor,
    )
)

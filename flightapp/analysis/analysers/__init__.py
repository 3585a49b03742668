"""All analysers of our recordings, in the order of the report; a new one is one small file and one line here."""

from flightapp.analysis.analysers import (
    battery,
    clock,
    failsafe,
    fence,
    link,
    near_miss,
    offboard,
    oscillation,
    perception,
    planner,
    saturation,
    separation,
    target,
)
from flightapp.analysis.analysers.analyser import Analyser

ANALYSERS: tuple[Analyser, ...] = tuple(
    module.ANALYSER
    for module in (
        near_miss,
        separation,
        fence,
        offboard,
        failsafe,
        perception,
        target,
        planner,
        oscillation,
        saturation,
        battery,
        link,
        clock,
    )
)

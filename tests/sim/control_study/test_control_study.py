"""The control study: one scene of it, what it is judged by, and bad input."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flightapp.core.errors import InputError
from flightapp.sim.control_study.campaign import study_methods, study_settings
from flightapp.sim.control_study.flown import FlownScene, Setting, fly_scene
from flightapp.sim.control_study.methods import REAL_PLANT
from flightapp.sim.control_study.reference import GAP_M, plan_course
from flightapp.sim.control_study.table import acceptance, as_markdown, rows_of
from flightapp.space.distance import signed_distance

SETTING = Setting("step 2 m, 17 obstacles", duration_s=30.0)


def test_the_courses_of_all_five_keep_off_bodies_and_off_each_other() -> None:
    course = plan_course(10_002, "level", 17, 2.0, 4)
    assert not isinstance(course, str)
    for places in course.references[:, ::20, :3]:
        assert min(signed_distance(course.bodies, *place, 0.0) for place in places.tolist()) > GAP_M - 0.3
    for one in range(5):
        for other in range(one):
            apart = np.linalg.norm(course.references[one, :, :3] - course.references[other, :, :3], axis=1)
            assert apart.min() >= 4.9


def test_ours_is_accepted_and_the_printed_gains_fail_on_a_vehicle_with_lag() -> None:
    scene = fly_scene(SETTING, 10_002, ("hybrid printed", "hybrid tuned"), (REAL_PLANT,))
    printed, ours = scene.flights
    assert ours.succeeded
    assert ours.figures.error_steady_m < 0.4 < printed.figures.error_steady_m
    assert printed.figures.limited_share > 0.9, "as printed it is a relay"
    verdict = acceptance([scene], REAL_PLANT.name)
    assert verdict.accepted
    broken = replace(scene, flights=(printed, replace(ours, pair_min_m=4.4)))
    assert acceptance([broken], REAL_PLANT.name).failed == ("step 2 m, 17 obstacles, seed 10002: pair 4.40 m",)
    table = as_markdown(rows_of([scene, FlownScene("x", 1, "no way", 0.0, 0.0, ())]), verdict.sentence)
    assert "| 99.85 | 2.63 | 5.32 |" in table


def test_an_unknown_way_or_method_is_refused() -> None:
    with pytest.raises(InputError, match='--method "magic": no such method; known: hybrid printed, smc printed'):
        study_methods(["hybrid tuned", "magic"])
    with pytest.raises(InputError, match="--way sideways: no such way; known: level, descent, climb"):
        study_settings("sideways", only_first=True)

"""Does the depth camera see, at its rate, without delay?"""

from __future__ import annotations

from flightapp.preflight.facts import Facts
from flightapp.preflight.result import Level, Result

NAME = "camera"
REASON = "without it obstacles are not known"
FRAME_AGE_MAX_S = 0.5
FIRST_FRAME_S = 10.0
RATE_FRACTION_MIN = 0.8
LATENCY_MAX_S = 0.1
PLUG = "check the plug (USB 3), the cable and camera.serial_number"


def judge(facts: Facts) -> tuple[Result, ...]:
    camera, config = facts.camera, facts.profile.camera
    if camera is None:
        if facts.vehicle.camera and config.source == "none":
            remedy = "set camera.source in the profile, or camera = false for this vehicle in the mission"
            return (Result(NAME, Level.FAILED, "the mission wants one, the profile has none", REASON, remedy),)
        return (Result(NAME, Level.SKIPPED, "this vehicle flies by the mission's surveyed obstacles", REASON),)
    if camera.failure or camera.fault:
        return (Result(NAME, Level.FAILED, camera.failure or camera.fault, REASON, PLUG),)
    if camera.frame_age_s is None or camera.frame_age_s > FRAME_AGE_MAX_S:
        level = Level.RUNNING if facts.waited_s < FIRST_FRAME_S else Level.FAILED
        found = "no frame yet" if camera.frame_age_s is None else f"no frame for {camera.frame_age_s:.1f} s"
        return (Result(NAME, level, found, REASON, PLUG),)
    found = f"{camera.rate_hz:.0f} Hz of {config.rate_hz:g} Hz"
    if camera.latency_s is not None:
        found += f", {camera.latency_s * 1e3:.0f} ms from light to discs"
    if camera.restarts:
        return (Result(NAME, Level.WARNING, f"{found}, restarted {camera.restarts} times", REASON, PLUG),)
    if camera.rate_hz < RATE_FRACTION_MIN * config.rate_hz:
        level = Level.RUNNING if facts.waited_s < FIRST_FRAME_S else Level.WARNING
        return (Result(NAME, level, found, REASON, PLUG),)
    if camera.warning:
        return (Result(NAME, Level.WARNING, f"{found}; {camera.warning}", REASON, PLUG),)
    if camera.latency_s is not None and camera.latency_s > LATENCY_MAX_S:
        return (Result(NAME, Level.WARNING, found, REASON, "something else uses the processor; see top"),)
    return (Result(NAME, Level.PASSED, found, REASON),)

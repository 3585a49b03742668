"""Colours (blue, green, red) that both halves of the picture share: what was seen now, what is remembered, what is unseen."""

from __future__ import annotations

from perception.view.lettering import Colour

SEEN_NOW: Colour = (50, 60, 225)
REMEMBERED: Colour = (200, 90, 60)
EXCLUDED: Colour = (70, 150, 40)
VELOCITY: Colour = (180, 0, 160)
UNSEEN: Colour = (205, 205, 205)
VEHICLE: Colour = (60, 110, 0)
WARNING: Colour = (80, 190, 255)
REMEMBERED_AGE_S = 0.05
"""A disc that was last seen longer ago than this is drawn as remembered."""


def disc_colour(age_s: float) -> Colour:
    return SEEN_NOW if age_s <= REMEMBERED_AGE_S else REMEMBERED

"""Heights of a layout's obstacles."""

from __future__ import annotations

import dataclasses

import numpy as np

from flightapp.core.errors import InputError
from flightapp.sim.batch.families.layout import Layout
from flightapp.sim.batch.seeds import Stream, sequence
from flightapp.sim.batch.volume.table import Volume

TOP, BOTTOM = 5, 6
"""Columns of discs."""


def with_heights(layout: Layout, volume: Volume, family: str, seed: int) -> Layout:
    """`layout` with heights of its obstacles, which stand on the ground, from a stream of their own."""
    if layout.polygons:
        raise InputError("volume: the layout has polygons, and those have no heights; leave [volume] out")
    random = np.random.default_rng([*sequence(family, seed, Stream.LAYOUT).generate_state(4).tolist(), TOP])
    discs = layout.discs.copy()
    discs[:, TOP], discs[:, BOTTOM] = -random.uniform(*volume.disc_height_m, len(discs)), 0.0
    return dataclasses.replace(layout, discs=discs)

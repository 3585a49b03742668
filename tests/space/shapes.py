"""Hypothesis strategies of bodies and points, shared by the tests of the three-dimensional world."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import strategies as st

from flightapp.space.shapes import Cylinder, OrientedBox, Sphere, SuperquadricCylinder

across = st.floats(-20, 20)
size = st.floats(0.2, 8)
speed = st.floats(-4, 4)
heading = st.floats(-math.pi, math.pi)
velocity = st.tuples(speed, speed, speed)
extent = st.tuples(st.floats(-25, 0), st.floats(0.5, 20)).map(lambda given: (given[0], given[0] + given[1]))
point = st.tuples(st.floats(-25, 25), st.floats(-25, 25), st.floats(-25, 25)).map(np.array)

sphere = st.builds(Sphere, across, across, across, size, velocity)
cylinder = st.builds(lambda n, e, r, z, v: Cylinder(n, e, r, *z, v), across, across, size, extent, velocity)
box = st.builds(
    lambda n, e, a, b, z, h, v: OrientedBox(n, e, a, b, *z, h, v), across, across, size, size, extent, heading, velocity
)
superquadric = st.builds(
    lambda n, e, r, k, z, h: SuperquadricCylinder(n, e, r, k, *z, h), across, across, size, st.floats(0.1, 1.9), extent, heading
)
shape = st.one_of(sphere, cylinder, box, superquadric)

"""The world in three dimensions: solid bodies, how far they are, what a straight way meets, and when.

Everything is in the mission frame, local NED in metres: a body's top has the smaller `down` than its bottom. A signed distance
is Euclidean, positive outside and negative inside; its gradient is the unit vector that leads away from the body.
Planar strategies do not import this package; `flightapp.core.clearance` is theirs.
"""

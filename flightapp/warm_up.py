"""`python -m flightapp.warm_up`: compile the numerical kernels into their cache, on the machine that will fly.

Numba keys its cache by CPU model, so this belongs into the install step on the flight computer.
"""

import flightapp.planning
import flightapp.sim.depth_renderer

__all__ = ["flightapp"]

"""The adaptive artificial potential field (Li and Duan 2025), its ablation and the methods that it is compared with.

Everything is in the mission frame, local NED; the specification's x, y, z are north, east and minus down, and no formula of it
depends on which way angles run. Forces are divided by mass, so they are accelerations, but only their direction and their size
relative to full attraction reach the setpoint.
"""

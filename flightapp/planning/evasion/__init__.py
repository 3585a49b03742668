"""Evader policies behind the planner interface: the pursuers arrive as the observation's team, there is no target."""

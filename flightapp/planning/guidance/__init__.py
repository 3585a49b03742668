"""Guidance points for vehicles that a local planner alone would leave standing: searched, pruned and flown one by one."""

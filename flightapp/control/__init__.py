"""Tracking control of one vehicle: disturbance observer, feedback with a sliding-mode term, avoidance, formation.

Source: Yan, Liu, Hao, "RRT*-APF path planning and MA-AADRC-SMC control for cooperative 3-D obstacle avoidance in multi-UAV
formations", Drones 9(9):611, 2025. Everything here is a pure function of flat float64 arrays and an explicit time step.
"""

"""Whole missions on a virtual clock, in one process: the application's own rooms, the mock autopilot, and nothing that waits."""

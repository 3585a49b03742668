"""Composition of one vehicle process: tasks, mission executive, deadman."""

"""Obstacles told between vehicles: which ones are worth telling, and what becomes of those that were heard. Free of I/O."""

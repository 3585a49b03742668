"""Whole simulated missions with random faults, and what must hold in each of them."""

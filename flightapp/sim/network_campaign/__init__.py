"""Whole simulated missions over bad links: what delay, jitter, loss and partitions do to a pursuit."""

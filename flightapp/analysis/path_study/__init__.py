"""Path planners compared on the same scenes: success, length, clearance, time, and whether the way can be flown."""

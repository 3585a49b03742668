"""AC2F: adaptive coarse-to-fine pursuit (Zhang, Zhou, Xue, Xue, Sensors 2026, 26(12), 3790)."""

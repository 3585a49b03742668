"""The scenes of the adaptive potential field's paper (Li and Duan 2025), flown as it flies them, beside its tables."""

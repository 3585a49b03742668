"""CPPPEA: cooperative hunting of a moving target. Li, Lu, Zhang, Zhang, J. Mar. Sci. Eng. 2025, 13(2), 221."""

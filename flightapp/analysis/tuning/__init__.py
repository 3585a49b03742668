"""Offline Bayesian optimisation of the fine stage's weights (section 7 of the AC2F specification)."""

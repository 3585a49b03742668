"""`pytest tests/planning/encirclement/test_degenerate.py -k world --hypothesis-profile=worlds`: 10 000 random worlds."""

from __future__ import annotations

from hypothesis import settings

settings.register_profile("worlds", max_examples=10_000, deadline=None)

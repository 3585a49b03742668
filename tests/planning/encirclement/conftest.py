"""`pytest tests/planning/encirclement/test_degenerate.py -k world --hypothesis-profile=worlds --timeout=0`: 10 000 worlds."""

from __future__ import annotations

from hypothesis import settings

settings.register_profile("worlds", max_examples=10_000, deadline=None)

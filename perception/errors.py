"""The error that a user sees as one sentence."""

from __future__ import annotations


class PerceptionInputError(Exception):
    """Bad input: the message names the file or field, the value and what would be right."""

"""Errors that a user sees as one sentence."""

from __future__ import annotations


class InputError(Exception):
    """Bad input: the message names the file, the field, the value and what would be right. Exit status 2."""


class FlightError(Exception):
    """The vehicle or its autopilot cannot do what the mission needs. Exit status 3."""

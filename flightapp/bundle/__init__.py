"""One file to send when asking for help, with nothing secret in it."""

from flightapp.bundle.writing import Bundle, write_bundle

__all__ = ["Bundle", "write_bundle"]

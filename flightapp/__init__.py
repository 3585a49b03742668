"""flightapp: cooperative UAV pursuit missions on companion computers."""

__version__ = "0.1.0"

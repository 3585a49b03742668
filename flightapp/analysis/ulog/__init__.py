"""The autopilot's own logs (PX4, `.ulg`): what they say of a flight, alone or beside our recordings."""

from flightapp.analysis.ulog.report import SUFFIX, LogReport, report_log

__all__ = ["SUFFIX", "LogReport", "report_log"]

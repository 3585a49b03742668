"""From the recordings of a run to numbers, a report and a picture."""

from flightapp.analysis.page import report, write_report
from flightapp.analysis.picture import write_picture
from flightapp.analysis.summary import write_summary

__all__ = ["report", "write_picture", "write_report", "write_summary"]

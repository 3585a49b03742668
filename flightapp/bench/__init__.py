"""Latency of the parts of one vehicle's control period, measured on the machine at hand."""

from flightapp.bench.run import run_bench

__all__ = ["run_bench"]

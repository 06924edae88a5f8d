"""The report: one HTML file that says where, which and how far."""

from brace_drake.report.page import WriteReport
from brace_drake.report.traces import RunTrace

__all__ = ["RunTrace", "WriteReport"]

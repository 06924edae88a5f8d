"""The report: one HTML file that says where, which and how far.

The document of a diagnosis comes in as it is written to diagnosis.json. Its
numbers are shown here, none is computed; the templates read them from the
document by their keys.
"""

from brace_drake.report.page import WriteReport
from brace_drake.report.traces import RunTrace

__all__ = ["RunTrace", "WriteReport"]

"""A diagnosis as files for a paper: one page, figures, tables."""

from brace_drake.report.export.figures import WriteFigures
from brace_drake.report.export.pdf import WritePdf
from brace_drake.report.export.tables import WriteTables

__all__ = ["WriteFigures", "WritePdf", "WriteTables"]

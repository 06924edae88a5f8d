"""The traces of all runs, to be zoomed in a page that loads nothing.

The charts are drawn by uPlot, which lies beside this file with its licence.
"""

from brace_drake.report.viewer.data import encode_runs
from brace_drake.report.viewer.scripts import viewer_script, viewer_style

__all__ = ["encode_runs", "viewer_script", "viewer_style"]

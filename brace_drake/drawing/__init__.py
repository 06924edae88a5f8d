"""Drawings of the diagrams: systems with ports and wires, bodies and joints."""

from brace_drake.drawing.kept import WriteKeptDrawings, draw_kept
from brace_drake.drawing.write import INSTALL, WriteDrawings, draw_svg

__all__ = [
    "INSTALL",
    "WriteDrawings",
    "WriteKeptDrawings",
    "draw_kept",
    "draw_svg",
]

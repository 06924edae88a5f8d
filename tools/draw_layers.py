"""Draws the table of tests/test_layering.py: who may import whom.

python tools/draw_layers.py docs/images/layers.svg
"""

from __future__ import annotations

import sys
from html import escape
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from tests.test_layering import LAYERS  # noqa: E402

_BOX, _GAP, _ROW, _CHAR, _PAD = 26, 8, 46, 7.3, 16


def draw_layers(layers: tuple[tuple[str, ...], ...]) -> str:
    """The rows from the top, arrows to what a row may know."""
    wide = [[_PAD + _CHAR * len(name) for name in row] for row in layers]
    width = max(sum(row) + _GAP * (len(row) - 1) for row in wide) + 60
    height = _ROW * len(layers) + 20
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}"'
        f' height="{height}" viewBox="0 0 {width:.0f} {height}"'
        ' font-family="DejaVu Sans Mono, Menlo, Consolas, monospace"'
        ' font-size="12">',
        "<title>Who may import whom</title>",
        '<defs><marker id="tip" markerWidth="8" markerHeight="8" refX="6"'
        ' refY="3" orient="auto"><path d="M0,0 L6,3 L0,6 z" fill="#51606d"/>'
        "</marker></defs>",
        f'<rect width="{width:.0f}" height="{height}" fill="#ffffff"/>',
    ]
    for i, (row, sizes) in enumerate(zip(layers, wide, strict=True)):
        x = (width - sum(sizes) - _GAP * (len(row) - 1)) / 2.0
        y = 16 + _ROW * i
        if i > 0:
            middle, top = width / 2.0, y - (_ROW - _BOX) + 3
            lines.append(
                f'<line x1="{middle:.1f}" y1="{y}" x2="{middle:.1f}"'
                f' y2="{top}" stroke="#51606d" marker-end="url(#tip)"/>'
            )
        for name, size in zip(row, sizes, strict=True):
            lines.append(
                f'<rect x="{x:.1f}" y="{y}" width="{size:.1f}"'
                f' height="{_BOX}" rx="4" fill="#e8f0f7" stroke="#2a6496"/>'
            )
            lines.append(
                f'<text x="{x + size / 2:.1f}" y="{y + 17}"'
                f' text-anchor="middle" fill="#1f2933">{escape(name)}</text>'
            )
            x += size + _GAP
    return "\n".join([*lines, "</svg>"]) + "\n"


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(draw_layers(LAYERS), encoding="utf-8")

"""Draws the table of tests/test_layering.py: who may import whom.

python tools/draw_layers.py docs/images/layers.svg
"""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from brace_drake.drawing import draw_svg  # noqa: E402
from tests.test_layering import LAYERS  # noqa: E402


def make_layer_graph(layers: tuple[tuple[str, ...], ...]) -> str:
    """The rows from the top, an arrow from each to what it may know."""
    lines = [
        'node [shape=record, style=filled, fillcolor="#e8f0f7",'
        ' fontname="DejaVu Sans Mono"];',
        "rankdir=BT; ranksep=0.2;",
    ]
    for i, row in enumerate(layers):
        lines.append(f'row{i} [label="{"|".join(row)}"];')
        if i:
            lines.append(f"row{i} -> row{i - 1};")
    return "\n".join(["digraph layers {", *lines, "}"])


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(
        draw_svg(make_layer_graph(LAYERS)), encoding="utf-8"
    )

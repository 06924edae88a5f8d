"""A laid out drawing as SVG text."""

from __future__ import annotations

from xml.sax.saxutils import escape

from brace_drake.drawing.place import (
    HEAD,
    MARGIN,
    SMALL_SIZE,
    TITLE_SIZE,
    Layout,
    PlacedBox,
    PlacedLink,
)

# Dark enough for thin lines on white, and apart for most colour vision.
_COLOURS = (
    "#0b62a4", "#b3421b", "#1d7a4d", "#7a3e9d",
    "#8a6100", "#b02a6b", "#00707a", "#55585c",
)  # fmt: skip
_FILLS = {"system": "#f4f7fb", "port": "#fff6df", "subject": "#e3eefb"}
_FONT = "DejaVu Sans Mono, Menlo, Consolas, monospace"


def make_svg(layout: Layout) -> str:
    """The drawing as a file of its own, without outside parts."""
    width, height = _number(layout.width), _number(layout.height)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" '
        f'height="{height}" viewBox="0 0 {width} {height}" '
        f'font-family="{_FONT}" font-size="{SMALL_SIZE}">',
        f"<title>{escape(layout.title)}</title>",
        '<rect width="100%" height="100%" fill="#ffffff"/>',
        f'<text x="{_number(MARGIN)}" y="{_number(MARGIN + TITLE_SIZE)}" '
        f'font-size="{TITLE_SIZE + 3}" font-weight="bold" fill="#1c2733">'
        f"{escape(layout.title)}</text>",
    ]
    parts += [_draw_link(link) for link in layout.links]
    for box in layout.boxes:
        parts += _draw_box(box)
    return "\n".join([*parts, "</svg>"]) + "\n"


def _draw_link(link: PlacedLink) -> str:
    (x, y), (u, v) = link.first, link.last
    colour = _COLOURS[(3 * link.wire.source + link.wire.output) % len(_COLOURS)]
    end = u - 6.0 if link.arrow else u
    if link.turns:
        t = _number(link.turns)
        curve = f"C{t} {_number(y)} {t} {_number(v)} {_point(end, v)}"
    elif abs(y - v) < 0.05:
        curve = f"L{_point(end, v)}"
    else:
        half = _number(0.5 * (x + u))
        curve = f"C{half} {_number(y)} {half} {_number(v)} {_point(end, v)}"
    dash = ' stroke-dasharray="5 4"' if link.wire.dashed else ""
    line = (
        f'<path d="M{_point(x, y)}{curve}" fill="none" stroke="{colour}" '
        f'stroke-width="1.4"{dash}/>'
    )
    if link.arrow:
        tips = _point(u, v), _point(u - 7, v - 3.5), _point(u - 7, v + 3.5)
        line += f'<path d="M{"L".join(tips)}Z" fill="{colour}"/>'
    return line


def _draw_box(placed: PlacedBox) -> list[str]:
    box, x, y = placed.box, placed.x, placed.y
    corner = 3 if box.kind != "port" else 10
    parts = [
        f'<rect x="{_number(x)}" y="{_number(y)}" '
        f'width="{_number(placed.width)}" height="{_number(placed.height)}" '
        f'rx="{corner}" fill="{_FILLS[box.kind]}" stroke="#5b6b7c"/>',
        _text(
            x + 0.5 * placed.width,
            y + 16.5,
            box.title,
            f'text-anchor="middle" font-size="{TITLE_SIZE}" '
            'font-weight="bold" fill="#1c2733"',
        ),
    ]
    if box.note:
        parts.append(
            _text(
                x + 0.5 * placed.width,
                y + HEAD + 6.0,
                box.note,
                'text-anchor="middle" fill="#5b6b7c"',
            )
        )
    sides = (
        ("in", box.inputs, x + 8.0, "start"),
        ("out", box.outputs, x + placed.width - 8.0, "end"),
    )
    for side, labels, at, anchor in sides:
        for row, label in enumerate(labels):
            if label:
                idle = (side, row) in box.unused
                fill = "#9aa5b1" if idle else "#1c2733"
                style = f'text-anchor="{anchor}" fill="{fill}"'
                height = placed.port_y(row) + 3.5
                parts.append(_text(at, height, label, style))
    return parts


def _text(x: float, y: float, words: str, style: str) -> str:
    place = f'x="{_number(x)}" y="{_number(y)}"'
    return f"<text {place} {style}>{escape(words)}</text>"


def _point(x: float, y: float) -> str:
    return f"{_number(x)} {_number(y)}"


def _number(value: float) -> str:
    """To a tenth of a pixel."""
    return f"{value:.1f}".removesuffix(".0")

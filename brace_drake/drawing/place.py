"""Places for boxes and wires: few crossings, short wires, no overlap."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from brace_drake.drawing.graph import Box, Graph, Wire
from brace_drake.drawing.layers import End, Layers, make_layers

# All in pixels; a letter of the fixed-width type is 0.6 of its size wide.
TITLE_SIZE, SMALL_SIZE, LETTER = 13.0, 10.5, 0.6
ROW, HEAD, MARGIN = 17.0, 24.0, 24.0
_NOTE, _PAD, _BETWEEN = 14.0, 10.0, 16.0
_LANE, _LANE_BETWEEN = 2.0, 11.0
_SWEEPS, _RELAXATIONS = 24, 120


@dataclass(frozen=True)
class PlacedBox:
    """A box and its rectangle; ports lie on its left and right side."""

    box: Box
    x: float
    y: float
    width: float
    height: float

    def port_y(self, row: int) -> float:
        return self.y + _port_offset(self.box, row)


@dataclass(frozen=True)
class PlacedLink:
    """A curve in a gap from first to last point, or a straight lane."""

    wire: Wire
    first: tuple[float, float]
    last: tuple[float, float]
    turns: float = 0.0  # x up to which it swings where it turns round
    arrow: bool = False  # whether it ends at a box


@dataclass(frozen=True)
class Layout:
    """A drawing laid out."""

    title: str
    width: float
    height: float
    boxes: list[PlacedBox]
    links: list[PlacedLink]


def place_graph(graph: Graph) -> Layout:
    """Lays out a graph; the same graph gives the same layout."""
    layers = make_layers(graph)
    y = _find_places(graph, layers)
    lowest = min(v for column in y for v in column.values())
    top = MARGIN + HEAD + ROW - lowest
    y = [{item: top + v for item, v in column.items()} for column in y]
    gaps = defaultdict(list)
    for link in layers.links:
        gaps[link.gap].append(link)
    columns, width = _find_columns(graph, layers, gaps)
    boxes = [None] * len(graph.boxes)
    for items, column, at in zip(layers.items, columns, y, strict=True):
        for kind, k in items:
            if kind == "box":
                box = graph.boxes[k]
                boxes[k] = PlacedBox(
                    box, column[0], at[kind, k], column[1], box_height(box)
                )
    links = _place_links(graph, gaps, columns, y)
    links += _place_lanes(layers, columns, y)
    bottom = [b.y + b.height for b in boxes] + [p.first[1] for p in links]
    title = 2 * MARGIN + len(graph.title) * LETTER * (TITLE_SIZE + 3)
    return Layout(
        graph.title, max(width, title), max(bottom) + MARGIN, boxes, links
    )


def _find_columns(graph: Graph, layers: Layers, gaps):
    """Left side and width of each layer, and the width of all."""
    columns, x = [], MARGIN + _gap_width(gaps[-1])
    for i, items in enumerate(layers.items):
        boxes = [graph.boxes[k] for kind, k in items if kind == "box"]
        columns.append((x, max(map(box_width, boxes), default=0.0)))
        x += columns[-1][1] + _gap_width(gaps[i])
    return columns, x + MARGIN


def _place_links(graph: Graph, gaps, columns, y) -> list[PlacedLink]:
    def point(end: End) -> tuple[float, float]:
        left, width = columns[end.layer]
        height = y[end.layer][end.item] + _offset(graph, end)
        return left + (width if end.on_left else 0.0), height

    links = []
    for found in gaps.values():
        room = _gap_width(found)
        for link in found:
            a, b = point(link.first), point(link.last)
            turn = 0.0
            if link.first.on_left == link.last.on_left:
                swing = min(room - 6.0, 14.0 + 0.12 * abs(a[1] - b[1]))
                turn = a[0] + (swing if link.first.on_left else -swing)
            arrow = link.last.item[0] == "box"
            links.append(PlacedLink(link.wire, a, b, turn, arrow))
    return links


def _place_lanes(layers: Layers, columns, y) -> list[PlacedLink]:
    wires = {link.wire.net: link.wire for link in layers.links}
    lanes = []
    for items, (left, width), at in zip(layers.items, columns, y, strict=True):
        for kind, net in items:
            if kind == "lane":
                height = at[kind, net]
                ends = (left, height), (left + width, height)
                lanes.append(PlacedLink(wires[net], *ends))
    return lanes


def box_width(box: Box) -> float:
    """Room for the title, the note, and the longest row of ports, px."""
    small, rows = LETTER * SMALL_SIZE, 0.0
    for row in range(max(len(box.inputs), len(box.outputs))):
        texts = [t[row] for t in (box.inputs, box.outputs) if row < len(t)]
        letters = small * sum(map(len, texts))
        rows = max(rows, letters + 2 * _PAD + 2 * small * len(texts))
    title = LETTER * TITLE_SIZE * len(box.title)
    return max(title + 2 * _PAD, small * len(box.note) + 2 * _PAD, rows, 44.0)


def box_height(box: Box) -> float:
    """Title, note, and a row for each port that has a label, px."""
    head = HEAD + (_NOTE if box.note else 0.0)
    labels = [*box.inputs, *box.outputs]
    if not any(labels):
        return head + (4.0 if box.note else 0.0)
    return head + ROW * max(len(box.inputs), len(box.outputs)) + 5.0


def _port_offset(box: Box, row: int) -> float:
    if not any((*box.inputs, *box.outputs)):
        return 0.5 * box_height(box)
    return HEAD + (_NOTE if box.note else 0.0) + ROW * (row + 0.5)


def _offset(graph: Graph, end: End) -> float:
    kind, index = end.item
    return _port_offset(graph.boxes[index], end.port) if kind == "box" else 0.0


def _gap_width(links: list) -> float:
    nets = len({link.wire.net for link in links})
    return min(34.0 + 7.0 * nets, 130.0) if nets else 0.0


def _find_places(graph: Graph, layers: Layers) -> list[dict[tuple, float]]:
    """y of each item, by sweeps that order a layer after its neighbours."""
    y, best, lowest = _stack(graph, layers), None, np.inf
    pulls = _pulls(graph, layers)
    for sweep in range(_SWEEPS):
        there = range(len(layers.items))
        for i in there if sweep % 2 == 0 else reversed(there):
            wish = _wishes(layers.items[i], i, y, pulls)
            layers.items[i].sort(key=lambda item, w=wish: w[item][0])
            y[i] = _spread(graph, layers.items[i], wish)
        cost = _cost(graph, layers, y)
        if cost < lowest:
            lowest, best = cost, [list(items) for items in layers.items]
    layers.items[:] = best
    y = _stack(graph, layers)
    for relaxation in range(_RELAXATIONS):
        there = range(len(layers.items))
        for i in there if relaxation % 2 == 0 else reversed(there):
            wish = _wishes(layers.items[i], i, y, pulls)
            y[i] = _spread(graph, layers.items[i], wish)
    return y


def _stack(graph: Graph, layers: Layers) -> list[dict[tuple, float]]:
    places = []
    for items in layers.items:
        still = {item: (0.0, 1.0) for item in items}
        places.append(_spread(graph, items, still))
    return places


def _pulls(graph: Graph, layers: Layers) -> dict:
    """Of each (layer, item): whom it is linked to, and the shift wanted."""
    pulls = defaultdict(list)
    for link in layers.links:
        for own, other in (link.first, link.last), (link.last, link.first):
            shift = _offset(graph, other) - _offset(graph, own)
            pulls[own.layer, own.item].append((other.layer, other.item, shift))
    return pulls


def _wishes(items, layer, y, pulls) -> dict[tuple, tuple[float, float]]:
    """Where each item would like to be, and how strongly."""
    wishes = {}
    for item in items:
        found = pulls.get((layer, item), [])
        at = [y[i][other] + shift for i, other, shift in found]
        own = y[layer][item]
        # Lanes are long: they keep straight before boxes come to meet them.
        weight = 4.0 if item[0] == "lane" else float(max(len(found), 1))
        wishes[item] = (float(np.mean(at)) if at else own, weight)
    return wishes


def _spread(graph: Graph, items: list, wish: dict) -> dict[tuple, float]:
    """Places closest to the wishes, in order and without overlap.

    Least squares under y_(i+1) >= y_i + room, by pooling adjacent violators.
    """
    offset, offsets, blocks = 0.0, [], []
    for k, item in enumerate(items):
        if k > 0:
            offset += _room(graph, items[k - 1], item)
        offsets.append(offset)
        wanted, weight = wish[item]
        blocks.append([wanted - offset, weight, 1])
        while len(blocks) > 1 and blocks[-2][0] > blocks[-1][0]:
            b, a = blocks.pop(), blocks.pop()
            total = a[1] + b[1]
            mean = (a[0] * a[1] + b[0] * b[1]) / total
            blocks.append([mean, total, a[2] + b[2]])
    starts = [mean for mean, _, count in blocks for _ in range(count)]
    return {
        item: start + o
        for item, start, o in zip(items, starts, offsets, strict=True)
    }


def _room(graph: Graph, item: tuple, following: tuple) -> float:
    """Least distance between the tops of two items, px."""
    boxes = (item[0], following[0]).count("box")
    between = _BETWEEN if boxes == 2 else _LANE_BETWEEN
    if item[0] == "lane":
        return _LANE + between
    return box_height(graph.boxes[item[1]]) + between


def _cost(graph: Graph, layers: Layers, y) -> float:
    """Crossings of wires, and a little for their length."""
    chords, length = defaultdict(list), 0.0
    for link in layers.links:
        ends = link.first, link.last
        at = [y[e.layer][e.item] + _offset(graph, e) for e in ends]
        length += abs(at[0] - at[1])
        # Round the gap: down its left side, up its right.
        turn = [
            p if e.on_left else 1e6 - p for p, e in zip(at, ends, strict=True)
        ]
        chords[link.gap].append((*sorted(turn), link.wire.net))
    crossings = 0
    for found in chords.values():
        for k, (a, b, net) in enumerate(found):
            for c, d, other in found[:k]:
                if net != other and (a < c < b) != (a < d < b):
                    crossings += 1
    return crossings + 1e-3 * length

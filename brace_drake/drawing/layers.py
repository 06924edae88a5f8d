"""Boxes in layers from left to right, and lanes for wires that pass them.

After Sugiyama, Tagawa and Toda, Methods for visual understanding of
hierarchical system structures, IEEE Trans. SMC 11, 1981; cycles are broken by
the heuristic of Eades, Lin and Smyth, 1993. A wire that leads back leaves its
box to the right like all others, turns round in the gap there and runs left
along lanes, so no wire meets a box but at a port.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from brace_drake.drawing.graph import Graph, Wire


@dataclass(frozen=True)
class End:
    """Where a link meets a gap.

    Attributes:
        layer: Of the item.
        item: ("box", index) or ("lane", net).
        port: Row of a box's port; 0 of a lane.
        on_left: Whether it lies on the gap's left side.
    """

    layer: int
    item: tuple
    port: int
    on_left: bool


@dataclass(frozen=True)
class Link:
    """A piece of a wire within the gap right of layer `gap`."""

    gap: int
    first: End
    last: End
    wire: Wire


@dataclass
class Layers:
    """Items of each layer, top to bottom, and the links between them."""

    items: list[list[tuple]]
    links: list[Link] = field(default_factory=list)


def make_layers(graph: Graph) -> Layers:
    """Boxes in layers, with lanes and links, in the order of the graph."""
    level = _levels(graph)
    items = [[] for _ in range(max(level, default=0) + 1)]
    for i, layer in enumerate(level):
        items[layer].append(("box", i))
    layers, seen = Layers(items), set()
    for wire in graph.wires:
        lanes = _lanes(level[wire.source], level[wire.target])
        for layer in lanes:
            lane = ("lane", wire.net)
            if lane not in items[layer]:
                items[layer].append(lane)
        for link in _links(wire, level, lanes):
            # Wires of a net share their links.
            key = link.gap, link.first, link.last
            if key not in seen:
                seen.add(key)
                layers.links.append(link)
    return layers


def _lanes(source: int, target: int) -> list[int]:
    """Layers that a wire passes along lanes, in its own order."""
    if source < target:
        return list(range(source + 1, target))
    return list(range(source, target - 1, -1))


def _links(wire: Wire, level: list[int], lanes: list[int]) -> list[Link]:
    source, target = level[wire.source], level[wire.target]
    forward = source < target
    lane, links = ("lane", wire.net), []
    at = End(source, ("box", wire.source), wire.output, True)
    for layer in lanes:
        # A lane is entered at one side and left at the other.
        end = End(layer, lane, 0, not forward)
        links.append(_link(at, end, wire))
        at = End(layer, lane, 0, forward)
    end = End(target, ("box", wire.target), wire.input, False)
    links.append(_link(at, end, wire))
    return links


def _link(first: End, last: End, wire: Wire) -> Link:
    gap = first.layer if first.on_left else first.layer - 1
    return Link(gap, first, last, wire)


def _levels(graph: Graph) -> list[int]:
    """Layer of each box: as far left as what feeds it allows."""
    n = len(graph.boxes)
    pairs = {(w.source, w.target) for w in graph.wires if w.source != w.target}
    place = {box: i for i, box in enumerate(_order(n, pairs))}
    ahead = [(a, b) for a, b in pairs if place[a] < place[b]]
    level = [0] * n
    for box in sorted(range(n), key=place.get):
        before = [level[a] for a, b in ahead if b == box]
        level[box] = 1 + max(before, default=-1)
    # What nothing feeds stands next to what it feeds.
    for box in range(n):
        if not any(b == box for _, b in ahead):
            after = [level[b] for a, b in ahead if a == box]
            level[box] = min(after, default=1) - 1
    return level


def _order(n: int, pairs: set[tuple[int, int]]) -> list[int]:
    """Boxes in an order against which few wires run."""
    left, right, rest = [], [], set(range(n))
    while rest:
        out = {i: sum(a == i and b in rest for a, b in pairs) for i in rest}
        into = {i: sum(b == i and a in rest for a, b in pairs) for i in rest}
        sinks = [i for i in sorted(rest) if out[i] == 0]
        starts = [i for i in sorted(rest) if into[i] == 0 and out[i] > 0]
        if sinks:
            right = sinks + right
            rest -= set(sinks)
        elif starts:
            left += starts
            rest -= set(starts)
        else:
            best = max(sorted(rest), key=lambda i: out[i] - into[i])
            left.append(best)
            rest.discard(best)
    return left + right

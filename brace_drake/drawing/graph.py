"""What is drawn: boxes with ports, and wires between ports."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Box:
    """A system, a body, or a port of the whole diagram.

    Attributes:
        title: Name; boxes may share it.
        note: A second line in small type; may be empty.
        inputs: Labels of the ports on the left, top to bottom.
        outputs: Labels of the ports on the right.
        kind: `system`, `port` of the whole, or `subject`, which stands out.
        unused: Ports that nothing is connected to, as (side, index), side "in"
            or "out".
    """

    title: str
    note: str = ""
    inputs: tuple[str, ...] = ()
    outputs: tuple[str, ...] = ()
    kind: str = "system"
    unused: frozenset[tuple[str, int]] = frozenset()


@dataclass(frozen=True)
class Wire:
    """From an output to an input, by indices of boxes and of their ports."""

    source: int
    output: int
    target: int
    input: int
    dashed: bool = False

    @property
    def net(self) -> tuple[int, int, bool]:
        """Wires of one net run together and part where they have to."""
        return self.source, self.output, self.dashed


@dataclass
class Graph:
    """A drawing before it is laid out."""

    title: str
    boxes: list[Box] = field(default_factory=list)
    wires: list[Wire] = field(default_factory=list)

    def add(self, box: Box) -> int:
        """Adds a box; returns its index."""
        self.boxes.append(box)
        return len(self.boxes) - 1

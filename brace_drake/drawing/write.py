"""Drawings of a scenario's diagram in a folder."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

from brace_drake.core.errors import OutputError
from brace_drake.core.output import MakeFolder, WriteText
from brace_drake.drawing.devices import MakeDrawnDiagram
from brace_drake.drawing.diagrams import (
    make_body_graph,
    make_part_graph,
    make_system_graph,
)
from brace_drake.drawing.graph import Graph
from brace_drake.drawing.place import place_graph
from brace_drake.drawing.svg import make_svg
from brace_drake.scenario.load import Scenario

INSTALL = "sudo apt-get install graphviz"


def WriteDrawings(scenario: Scenario, folder: str | Path) -> list[Path]:
    """Writes what a scenario's diagram consists of.

    `system` is all systems, `bodies` the plant's bodies and joints (where
    there is a plant), `parts/NAME` each system with all its ports. Of each
    there is Drake's own graph, `.dot`, and a drawing of this package, `.svg`,
    which needs nothing else; where Graphviz is installed also its drawing,
    `.dot.svg`.

    Returns:
        The files.

    Raises:
        OutputError: The folder cannot be written to, or `dot` fails.
    """
    folder = MakeFolder(Path(folder))
    parts = MakeFolder(folder / "parts")
    diagram, plant, closures = MakeDrawnDiagram(scenario)
    texts = {
        folder / "system": (
            make_system_graph(diagram),
            diagram.GetGraphvizString(),
        )
    }
    if plant is not None:
        texts[folder / "bodies"] = (
            make_body_graph(plant, closures),
            plant.GetTopologyGraphvizString(),
        )
    for system in diagram.GetSystems():
        texts[parts / system.get_name()] = (
            make_part_graph(diagram, system),
            system.GetGraphvizString(),
        )
    written = []
    for path, (graph, dot) in texts.items():
        written += _WriteBoth(path, graph, dot)
    return written


def draw_svg(graph: Graph) -> str:
    """The drawing of a graph; the same graph gives the same text."""
    return make_svg(place_graph(graph))


def _WriteBoth(path: Path, graph: Graph, dot: str) -> list[Path]:
    files = [path.with_name(f"{path.name}{end}") for end in (".svg", ".dot")]
    WriteText(files[0], draw_svg(graph))
    WriteText(files[1], dot)
    program = shutil.which("dot")
    if program is None:
        return files
    command = [program, "-Tsvg", str(files[1])]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise OutputError(f"{files[1]}: dot: {done.stderr.strip()}")
    files.append(path.with_name(f"{path.name}.dot.svg"))
    WriteText(files[2], done.stdout)
    return files

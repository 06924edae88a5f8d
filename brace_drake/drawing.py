"""Drawings of a scenario's diagram: Drake's graphs, drawn by Graphviz."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import Diagram

from brace_drake.core.errors import OutputError, ScenarioError
from brace_drake.core.output import MakeFolder, WriteText
from brace_drake.core.resources import scenario_path
from brace_drake.model.articulated import GetClosures
from brace_drake.model.brace_station import MakeControlledBrace
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.load import LoadScenario, Scenario

INSTALL = "apt-get install graphviz, or brew install graphviz"

# Drawings that lie in diagrams/: file, scenario, laid over it, which graph.
_KEPT = (
    ("bench.svg", "bench", None, "system"),
    ("brace.svg", "brace", None, "system"),
    ("brace_articulated.svg", "brace", "mechanism: articulated", "system"),
    (
        "brace_articulated_bodies.svg",
        "brace",
        "mechanism: articulated",
        "bodies",
    ),
)


def WriteDrawings(scenario: Scenario, folder: str | Path) -> list[Path]:
    """Writes the graphs of a scenario's diagram as `.dot` and as `.svg`.

    `system` is all systems, `bodies` the plant's bodies and joints (where
    there is a plant), `parts/NAME` each system with its ports.

    Returns:
        The files.

    Raises:
        OutputError: The folder cannot be written to, or Graphviz is missing
            or fails; the `.dot` files are there all the same.
    """
    folder = MakeFolder(Path(folder))
    MakeFolder(folder / "parts")
    graphs = make_graphs(scenario)
    files = {name: folder / f"{name}.dot" for name in graphs}
    for name, file in files.items():
        WriteText(file, graphs[name])
    drawings = [file.with_suffix(".svg") for file in files.values()]
    for name, drawing in zip(files, drawings, strict=True):
        WriteText(drawing, draw_svg(graphs[name]))
    return [*files.values(), *drawings]


def WriteKeptDrawings() -> list[Path]:
    """Draws anew what lies beside the scenarios; returns the files.

    Raises:
        OutputError: A file cannot be written, or Graphviz is missing or fails.
    """
    paths = []
    for file, graph in make_kept_graphs().items():
        paths.append(scenario_path(file))
        WriteText(paths[-1], draw_svg(graph))
    return paths


def make_kept_graphs() -> dict[str, str]:
    """Graphs of the drawings that lie beside the scenarios, by file."""
    return {
        file: make_graphs(
            LoadScenario(scenario_path(f"{name}.scenario.yaml"), overrides)
        )[graph]
        for file, name, overrides, graph in _KEPT
    }


def draw_svg(dot: str) -> str:
    """Graphviz's drawing of a graph.

    Raises:
        OutputError: There is no program `dot`, or it fails.
    """
    program = shutil.which("dot")
    if program is None:
        raise OutputError(f"drawings need Graphviz: {INSTALL}")
    done = subprocess.run(
        [program, "-Tsvg"],
        input=dot,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        raise OutputError(f"dot: {done.stderr.strip()}")
    return done.stdout


def make_graphs(scenario: Scenario) -> dict[str, str]:
    """Graphs of a scenario's diagram in Graphviz's language, by name."""
    diagram, plant, closures = MakeDrawnDiagram(scenario)
    graphs = {"system": diagram.GetGraphvizString()}
    if plant is not None:
        graphs["bodies"] = make_body_graph(plant, closures)
    for system in diagram.GetSystems():
        graphs[f"parts/{system.get_name()}"] = system.GetGraphvizString()
    return graphs


def make_body_graph(
    plant: MultibodyPlant, closures: list[tuple[RigidBody, RigidBody]]
) -> str:
    """A plant's bodies and joints from left to right, the world first.

    Args:
        plant: Finalized.
        closures: Pairs of bodies that a constraint holds together, drawn
            dashed: Drake's graph has joints only.
    """
    dot = plant.GetTopologyGraphvizString().rstrip().removesuffix("}")
    dot = dot.replace("rankdir=BT", "rankdir=RL")
    # A ring that closes loops stands beyond its legs, as it does in the brace.
    dashed = [
        f"body{int(b.index())} -> body{int(a.index())}"
        " [style=dashed, dir=none];\n"
        for a, b in closures
    ]
    return f"{dot}{''.join(dashed)}}}\n"


def MakeDrawnDiagram(
    scenario: Scenario,
) -> tuple[Diagram, MultibodyPlant | None, list[tuple[RigidBody, RigidBody]]]:
    """The diagram of any scenario, with its own controller.

    Returns:
        The diagram; its plant, where it has one; and pairs of bodies that
        constraints hold together.
    """
    if not isinstance(scenario, BraceScenario):
        raise ScenarioError(
            f"a {scenario.device} has no diagram: its twin is one compiled law"
        )
    station = MakeControlledBrace(scenario)
    closures = []
    if scenario.mechanism == "articulated":
        closures = GetClosures(station.plant, scenario)
    return station.diagram, station.plant, closures

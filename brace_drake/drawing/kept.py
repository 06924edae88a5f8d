"""The drawings that lie beside the scenarios, in `diagrams/`."""

from __future__ import annotations

from pathlib import Path

from brace_drake.core.output import WriteText
from brace_drake.core.resources import scenario_path
from brace_drake.drawing.devices import MakeDrawnDiagram
from brace_drake.drawing.diagrams import make_body_graph, make_system_graph
from brace_drake.drawing.write import draw_svg
from brace_drake.scenario.load import LoadScenario

# Scenario, and what is laid over it; files are of systems, then of bodies.
_KEPT = {
    ("bench", None): ("bench.svg", None),
    ("brace", None): ("brace.svg", None),
    ("brace", "mechanism: articulated"): (
        "brace_articulated.svg",
        "brace_articulated_bodies.svg",
    ),
}


def draw_kept() -> dict[str, str]:
    """Texts of the drawings by file name."""
    texts = {}
    for (name, overrides), files in _KEPT.items():
        path = scenario_path(f"{name}.scenario.yaml")
        diagram, plant, closures = MakeDrawnDiagram(
            LoadScenario(path, overrides)
        )
        texts[files[0]] = draw_svg(make_system_graph(diagram))
        if files[1]:
            texts[files[1]] = draw_svg(make_body_graph(plant, closures))
    return texts


def WriteKeptDrawings() -> list[Path]:
    """Draws them anew; returns the files.

    Raises:
        OutputError: A file cannot be written.
    """
    paths = []
    for name, text in draw_kept().items():
        paths.append(scenario_path(name))
        WriteText(paths[-1], text)
    return paths

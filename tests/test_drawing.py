"""Drawings of the diagrams: complete, and current."""

import re
import shutil
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from unittest import mock

import pydot

from brace_drake.core.errors import OutputError
from brace_drake.core.resources import scenario_path
from brace_drake.drawing import (
    INSTALL,
    MakeDrawnDiagram,
    WriteDrawings,
    draw_svg,
    make_graphs,
    make_kept_graphs,
)
from brace_drake.scenario.load import LoadScenario

# Names of ports and systems, of bodies, and of joints.
_WORDS = re.compile(r'>([^<>\n]+)<|^(name=[^<\n]+)|label="([^"]+)"', re.M)


def load(name, overrides=None):
    return LoadScenario(scenario_path(f"{name}.scenario.yaml"), overrides)


def words_of(svg):
    """All texts of a drawing, and its number of arrows."""
    nodes = list(ElementTree.fromstring(svg).iter())
    arrows = sum(node.get("class") == "edge" for node in nodes)
    texts = {n.text for n in nodes if n.tag.endswith("}text")}
    return texts, arrows


class TestDrawing(unittest.TestCase):
    def test_the_drawings_beside_the_scenarios_are_current(self):
        for name, graph in make_kept_graphs().items():
            with self.subTest(drawing=name, run="python diagrams/draw.py"):
                texts, arrows = words_of(scenario_path(name).read_text())
                found = {w for m in _WORDS.findall(graph) for w in m if w}
                # Graphviz leaves out what holds nothing.
                found.discard("DefaultModelInstance")
                self.assertEqual(texts, found)
                self.assertEqual(arrows, graph.count("->"))

    def test_every_kind_of_scenario_has_graphs_of_the_whole_and_its_parts(self):
        for name in ("bench", "brace"):
            scenario = load(name)
            graphs = make_graphs(scenario)
            diagram, plant, _ = MakeDrawnDiagram(scenario)
            parts = {f"parts/{s.get_name()}" for s in diagram.GetSystems()}
            parts |= {"system"} | ({"bodies"} if plant else set())
            self.assertEqual(set(graphs), parts)
            for graph in graphs.values():
                (dot,) = pydot.graph_from_dot_data(graph)
                self.assertEqual(dot.get_type(), "digraph")

    def test_the_articulated_brace_has_its_joints_and_closed_loops(self):
        bodies = make_graphs(load("brace", "mechanism: articulated"))["bodies"]
        dashed = [a for a in bodies.splitlines() if "dashed" in a]
        # Six legs in each of three stages, of three bodies each.
        self.assertEqual(len(dashed), 18)
        # World, four rings, torso, the legs; a joint for each but the world.
        self.assertEqual(len(re.findall(r"^ body\d+ \[", bodies, re.M)), 60)
        self.assertEqual(bodies.count("->") - len(dashed), 59)

    def test_without_graphviz_the_graphs_are_there_and_one_line_helps(self):
        with (
            tempfile.TemporaryDirectory() as folder,
            mock.patch("shutil.which", return_value=None),
        ):
            with self.assertRaisesRegex(OutputError, re.escape(INSTALL)):
                WriteDrawings(load("bench"), folder)
            self.assertTrue((Path(folder) / "system.dot").is_file())

    @unittest.skipUnless(shutil.which("dot"), "needs Graphviz")
    def test_a_folder_holds_graph_and_drawing_of_the_whole_and_of_parts(self):
        with tempfile.TemporaryDirectory() as folder:
            files = WriteDrawings(load("bench"), folder)
            for file in files:
                self.assertTrue(file.is_file(), file)
            texts, _ = words_of((Path(folder) / "parts/plant.svg").read_text())
            self.assertIn("name=plant", texts)

    @unittest.skipUnless(shutil.which("dot"), "needs Graphviz")
    def test_what_graphviz_does_not_read_is_an_error(self):
        with self.assertRaisesRegex(OutputError, "dot: "):
            draw_svg("digraph {")


if __name__ == "__main__":
    unittest.main()

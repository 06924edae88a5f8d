"""Drawings of the diagrams: complete, without overlap, and current."""

import tempfile
import unittest
import xml.etree.ElementTree as ElementTree
from collections import defaultdict
from itertools import combinations

import numpy as np
import pydot

from brace_drake.core.resources import scenario_path
from brace_drake.drawing import WriteDrawings, draw_kept
from brace_drake.drawing.devices import MakeDrawnDiagram
from brace_drake.drawing.diagrams import (
    make_body_graph,
    make_part_graph,
    make_system_graph,
)
from brace_drake.drawing.graph import Box, Graph, Wire
from brace_drake.drawing.place import LETTER, SMALL_SIZE, place_graph
from brace_drake.drawing.svg import make_svg
from brace_drake.scenario.load import LoadScenario

DEVICES = (
    ("bench", None),
    ("bench", "control: {layout: blocks}"),
    ("bench", "contact: {model: hydroelastic}"),
    ("leg_bench", None),
    ("pad_bench", None),
    ("brace", None),
    ("brace", "mechanism: articulated"),
)


def drawn(name, overrides=None):
    path = scenario_path(f"{name}.scenario.yaml")
    return MakeDrawnDiagram(LoadScenario(path, overrides))


def points(link):
    """A link's curve as the SVG has it, (n, 2)."""
    (x, y), (u, v) = link.first, link.last
    c = link.turns or 0.5 * (x + u)
    t = np.linspace(0.0, 1.0, 60)[:, None]
    ends = np.array([[x, y], [c, y], [c, v], [u, v]])
    weights = np.hstack(
        [(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3]
    )
    return weights @ ends


class TestGraphs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.drawn = [drawn(*device) for device in DEVICES]
        cls.systems = [make_system_graph(d) for d, _, _ in cls.drawn]
        cls.bodies = [make_body_graph(p, c) for _, p, c in cls.drawn if p]
        cls.graphs = cls.systems + cls.bodies
        cls.layouts = [place_graph(graph) for graph in cls.graphs]

    def test_every_system_and_every_connection_is_drawn(self):
        for (diagram, _, _), graph in zip(
            self.drawn, self.systems, strict=True
        ):
            with self.subTest(diagram=diagram.get_name()):
                names = [s.get_name() for s in diagram.GetSystems()]
                titles = [b.title for b in graph.boxes if b.kind == "system"]
                self.assertEqual(titles, names)
                entering = sum(
                    len(
                        diagram.GetInputPortLocators(
                            diagram.get_input_port(i).get_index()
                        )
                    )
                    for i in range(diagram.num_input_ports())
                )
                self.assertEqual(
                    len(graph.wires),
                    len(diagram.connection_map())
                    + entering
                    + diagram.num_output_ports(),
                )
                text = make_svg(place_graph(graph))
                found = [e.text for e in ElementTree.fromstring(text).iter()]
                for name in names:
                    self.assertIn(name, found)

    def test_names_do_not_hang_on_where_a_system_lies_in_memory(self):
        for graph in self.systems:
            for box in graph.boxes:
                self.assertNotIn("@", box.title)

    def test_a_wire_joins_the_ports_that_drake_joins(self):
        diagram, graph = self.drawn[0][0], self.systems[0]
        ends = {
            (
                graph.boxes[w.source].title,
                graph.boxes[w.source].outputs[w.output].split(" ")[0],
                graph.boxes[w.target].title,
                graph.boxes[w.target].inputs[w.input].split(" ")[0],
            )
            for w in graph.wires
        }
        for (target, port), (
            source,
            output,
        ) in diagram.connection_map().items():
            names = (
                source.get_name(),
                source.get_output_port(output).get_name(),
                target.get_name(),
                target.get_input_port(port).get_name(),
            )
            self.assertIn(names, ends)
        self.assertIn(("noise [12]", "", "pic_controller", "noise"), ends)

    def test_boxes_do_not_overlap(self):
        for layout in self.layouts:
            for a, b in combinations(layout.boxes, 2):
                apart = (
                    a.x + a.width < b.x
                    or b.x + b.width < a.x
                    or a.y + a.height < b.y
                    or b.y + b.height < a.y
                )
                self.assertTrue(apart, f"{a.box.title}, {b.box.title}")

    def test_no_wire_runs_through_a_box(self):
        for layout in self.layouts:
            for link in layout.links:
                x, y = points(link).T
                for b in layout.boxes:
                    inside = (x > b.x + 0.1) & (x < b.x + b.width - 0.1)
                    inside &= (y > b.y) & (y < b.y + b.height)
                    self.assertFalse(inside.any(), b.box.title)

    def test_every_wire_leads_from_its_output_to_its_input(self):
        for graph, layout in zip(self.graphs, self.layouts, strict=True):
            ways = defaultdict(list)
            for link in layout.links:
                ways[link.wire.net].append((link.first, link.last))
            for wire in graph.wires:
                a, b = layout.boxes[wire.source], layout.boxes[wire.target]
                start = a.x + a.width, a.port_y(wire.output)
                goal = b.x, b.port_y(wire.input)
                reached, grown = {start}, True
                while grown:
                    size = len(reached)
                    for pair in ways[wire.net]:
                        if reached.intersection(pair):
                            reached.update(pair)
                    grown = len(reached) > size
                self.assertIn(goal, reached)

    def test_everything_lies_on_the_page_and_texts_fit_their_boxes(self):
        for layout in self.layouts:
            for link in layout.links:
                x, y = points(link).T
                self.assertTrue(0 < x.min() and x.max() < layout.width)
                self.assertTrue(0 < y.min() and y.max() < layout.height)
            for b in layout.boxes:
                rows = max(len(b.box.inputs), len(b.box.outputs))
                self.assertLess(b.x + b.width, layout.width)
                self.assertLess(b.y + b.height, layout.height)
                for row in range(rows):
                    texts = [
                        side[row]
                        for side in (b.box.inputs, b.box.outputs)
                        if row < len(side)
                    ]
                    letters = LETTER * SMALL_SIZE * len("".join(texts))
                    self.assertLess(letters + 16.0, b.width + 1e-9)
                    if any(texts):
                        self.assertLess(b.port_y(row), b.y + b.height)

    def test_the_articulated_brace_has_its_bodies_joints_and_closed_loops(self):
        graph = self.bodies[-1]
        dashed = [w for w in graph.wires if w.dashed]
        self.assertEqual(len(dashed), 18)
        for wire in dashed:
            self.assertEqual(graph.boxes[wire.source].title, "rod")
            self.assertIn("ring", graph.boxes[wire.target].title)
        # World, four rings, torso, 18 legs of three; a joint for each.
        self.assertEqual(len(graph.boxes), 60)
        self.assertEqual(len(graph.wires) - len(dashed), 59)

    def test_a_part_shows_all_its_ports(self):
        diagram, plant, _ = self.drawn[0]
        graph = make_part_graph(diagram, plant)
        (subject,) = (b for b in graph.boxes if b.kind == "subject")
        self.assertEqual(len(subject.inputs), plant.num_input_ports())
        self.assertEqual(len(subject.outputs), plant.num_output_ports())
        ends = [b.title for b in graph.boxes if b is not subject]
        readers = ["forces_inputs", "state_log", "plant_state [26]"]
        self.assertEqual(ends, ["forces", *readers])
        idle = plant.num_input_ports() + plant.num_output_ports() - 2
        self.assertEqual(len(subject.unused), idle)


class TestLayout(unittest.TestCase):
    def test_wires_of_a_ladder_do_not_cross_whatever_the_order(self):
        graph = Graph("ladder")
        for i in range(5):
            graph.add(Box(f"a{i}", outputs=("y",)))
        for i in (3, 0, 4, 1, 2):
            graph.add(Box(f"b{i}", inputs=("u",)))
        for k, i in enumerate((3, 0, 4, 1, 2)):
            graph.wires.append(Wire(i, 0, 5 + k, 0))
        links = place_graph(graph).links
        for a, b in combinations(links, 2):
            before = a.first[1] < b.first[1]
            self.assertEqual(before, a.last[1] < b.last[1])

    def test_a_loop_of_one_system_goes_round_it(self):
        graph = Graph("loop", [Box("a", inputs=("u",), outputs=("y",))])
        graph.wires.append(Wire(0, 0, 0, 0))
        layout = place_graph(graph)
        (box,) = layout.boxes
        (lane,) = (p for p in layout.links if not p.arrow and not p.turns)
        self.assertGreater(lane.first[1], box.y + box.height)


class TestFiles(unittest.TestCase):
    def test_the_drawings_beside_the_scenarios_are_current(self):
        for name, text in draw_kept().items():
            with self.subTest(drawing=name):
                path = scenario_path(name)
                self.assertEqual(
                    path.read_text(), text, "run: python diagrams/draw.py"
                )
                self.assertLess(path.stat().st_size, 100_000)

    def test_a_folder_holds_graph_and_drawing_of_the_whole_and_of_parts(self):
        scenario = LoadScenario(scenario_path("leg_bench.scenario.yaml"))
        with tempfile.TemporaryDirectory() as folder:
            files = WriteDrawings(scenario, folder)
            names = {str(f.relative_to(folder)) for f in files}
            for name in ("system", "bodies", "parts/plant", "parts/servo"):
                self.assertLessEqual({f"{name}.dot", f"{name}.svg"}, names)
            for file in files:
                text = file.read_text()
                if file.suffix == ".dot":
                    (dot,) = pydot.graph_from_dot_data(text)
                    self.assertEqual(dot.get_type(), "digraph")
                    if file.stem in ("system", "servo"):
                        self.assertIn("name=servo", text)
                else:
                    root = ElementTree.fromstring(text)
                    self.assertTrue(root.tag.endswith("svg"))


if __name__ == "__main__":
    unittest.main()

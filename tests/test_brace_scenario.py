"""The scenario of the whole brace and what may stand in it."""

import tempfile
import unittest
from dataclasses import fields, is_dataclass
from pathlib import Path

import numpy as np
import yaml

from brace_drake.core.errors import ScenarioError
from brace_drake.core.resources import scenario_path
from brace_drake.scenario.brace import BenchScenario, BraceScenario
from brace_drake.scenario.brace_numbers import pack_bench, pack_brace
from brace_drake.scenario.load import LoadScenario, SaveScenario
from tests.test_scenario import SHEET, differences

BRACE = scenario_path("brace.scenario.yaml")


class TestBraceFile(unittest.TestCase):
    def test_the_file_holds_the_defaults(self):
        loaded, default = LoadScenario(BRACE), BraceScenario()
        self.assertEqual(differences(loaded, default), [])

    def test_the_file_is_complete(self):
        def missing(node, data, at=""):
            for f in fields(node):
                child = getattr(node, f.name)
                if f.name not in data:
                    yield f"{at}{f.name}"
                elif is_dataclass(child):
                    yield from missing(child, data[f.name], f"{at}{f.name}.")

        data = yaml.safe_load(BRACE.read_text())
        self.assertEqual(list(missing(BraceScenario(), data)), [])

    @unittest.skipUnless(SHEET.is_file(), "needs the data sheet")
    def test_the_defaults_are_those_of_the_data_sheet(self):
        text = SHEET.read_text()
        # Its first key is prose.
        sheet = yaml.safe_load(text[text.index("\nbrace:") :])
        brace, bench, ours = sheet["brace"], sheet["bench"], BraceScenario()
        equal = np.testing.assert_array_equal
        equal(ours.ring_heights, brace["ring_heights"])
        equal(ours.ring.half_axes, brace["ring_outer_half_axes"])
        for i, stage in brace["stages"].items():
            joints = getattr(ours.joints, f"stage{i}")
            for side, circle in stage.items():
                at = getattr(joints, side)
                self.assertEqual(at.radius, circle["radius"])
                equal(at.angles_deg, circle["angles_deg"])
        parts = [
            ("ring", ours.ring, brace["moving_ring"]),
            ("leg", ours.leg, brace["leg"]),
            ("sensors", ours.sensors, bench["sensors"]),
            ("torso", ours.torso, bench["torso"]),
        ]
        parts += [("pads", c, bench["contact"]) for c in ours.contacts]
        for name, part, values in parts:
            for key, value in values.items():
                if key == "gravity":
                    continue
                with self.subTest(key=f"{name}.{key}"):
                    equal(getattr(part, key), value)
        for contact in ours.contacts:
            equal(contact.pad_size, brace["pads"]["size"])
            self.assertEqual(contact.pad_offset, brace["pads"]["offset"])
        control, sheet = ours.control, bench["control"]
        for values, name in (
            (control.rate, "rate"),
            (control.estimation.velocity_cutoff_hz, "velocity_cutoff_hz"),
            (control.estimation.force_filter_tau, "force_filter_tau"),
            (control.inner.kp, "kp"),
            (control.inner.kd, "kd"),
            (control.impedance.mass, "desired_mass"),
            (control.impedance.stiffness, "desired_stiffness"),
        ):
            equal(values, np.full_like(values, sheet[name]))

    def test_stage_2_alone_has_the_numbers_of_the_bench(self):
        numbers = pack_brace(BraceScenario(stages=[2]))
        bench = pack_bench(BenchScenario())
        for name in numbers._fields:
            ours, theirs = getattr(numbers, name), getattr(bench, name)
            with self.subTest(name=name):
                np.testing.assert_allclose(ours, theirs, rtol=1e-15, atol=0)


class TestBadScenarios(unittest.TestCase):
    def setUp(self):
        folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.path = folder / "some.scenario.yaml"

    def load(self, text):
        self.path.write_text("device: brace\n" + text)
        return LoadScenario(self.path)

    def test_a_saved_scenario_loads_as_it_was(self):
        scenario = self.load(
            "stages: [2, 3]\nstart: {ring3: [0, 0, 1.0e-3, 0, 0, 0]}"
        )
        SaveScenario(scenario, self.path)
        again = LoadScenario(self.path)
        self.assertEqual(again.stages, [2, 3])
        np.testing.assert_array_equal(again.start.ring3, [0, 0, 1e-3, 0, 0, 0])

    def test_a_controller_takes_a_number_for_each_coordinate(self):
        scenario = self.load(
            "stages: [2, 3]\ncontrol: {tag: idc, inner: {kp:"
            " [900, 900, 900, 900, 900, 900, 800, 800, 800, 800, 800, 800]}}"
        )
        self.assertEqual(scenario.control.tag, "idc")
        np.testing.assert_array_equal(
            scenario.control.inner.kp, np.repeat([900, 800], 6)
        )

    def test_bad_files_are_told_in_one_line(self):
        cases = {
            "stages: [1, 3]": ("stages is [1, 3]", "neighbours"),
            "stages: []": ("stages", "neighbours"),
            "stages: [3, 4]": ("stages", "1, 2, 3"),
            "stages: [2.0]": ("stages[0]", "a whole number"),
            "stages: 2": ("stages", "a list"),
            "mechanism: rigid": ("mechanism", "task_space or articulated"),
            "rings: 3": ("rings", "no such key, did you mean ring?"),
            "ring: {mass: -1}": ("ring.mass", "-1", "greater than 0"),
            "ring: {inertia: [1, 1, 3]}": ("ring.inertia", "sum"),
            "leg: {tube_mass: -0.1}": ("leg.tube_mass", "greater than 0"),
            "leg: {stroke: 0.1}": ("leg.stroke is 0.1", "less than 0.0894"),
            "ring_heights: [0, 0.1, 0.1, 0.2]": ("ring_heights", "above"),
            "ring_heights: [0, 0.1]": ("ring_heights", "4 numbers"),
            "joints: {stage2: {upper: {radius: 0}}}": (
                "joints.stage2.upper.radius",
                "greater than 0",
            ),
            "joints: {stage2: {upper: {angles_deg: [1, 2]}}}": (
                "joints.stage2.upper.angles_deg",
                "6 numbers",
            ),
            "joints: {stage1: {lower: {radius: 0.1, angles_deg: [-47, 47, 73,"
            " 167, 193, 287]}}}": ("joints", "singular at rest"),
            "start: {ring2: [0, 0.04, 0, 0, 0, 0]}": (
                "start.ring2",
                "leg",
                "half its stroke",
            ),
            "start: {ring3: [0, 0, 0, 1.0e+308, 0, 0]}": (
                "start.ring3",
                "1e+12",
            ),
            "start: {ring3: [0, 0, 0, 3.0, 0, 0]}": (
                "start.ring3",
                "a pose in reach",
            ),
            "start: {ring3: [0, 0, -0.0249, 0, 0, 0.31]}": (
                "start.ring3",
                "a pose in reach",
            ),
            "contact: {ring3: {model: soft}}": (
                "contact.ring3.model",
                "linear or none or hydroelastic",
            ),
            "contact: {ring1: {damping: -1}}": (
                "contact.ring1.damping",
                "0 or more",
            ),
            "contact: {ring1: {preload: 0.2}}": (
                "contact.ring1.preload",
                "less than contact.ring1.pad_offset",
            ),
            "control: {tag: mraci}": (
                "control.tag",
                "did you mean mraic?",
            ),
            "control: {inner: {kp: [high]}}": (
                "control.inner.kp[0]",
                "a number",
            ),
            "control: {inner: {kp: []}}": (
                "control.inner.kp",
                "6 or 18 numbers",
            ),
            "control: {inner: {kp: [.nan, 1, 1, 1, 1, 1]}}": (
                "control.inner.kp",
                "finite numbers",
            ),
            "time_step: 0.0007": ("time_step", "0.001"),
            "workspace: {singular_value: 0}": (
                "workspace.singular_value",
                "greater than 0",
            ),
        }
        for text, parts in cases.items():
            with self.subTest(text=text):
                with self.assertRaises(ScenarioError) as caught:
                    self.load(text)
                self.assertNotIn("\n", str(caught.exception))
                for part in ("some.scenario.yaml", *parts):
                    self.assertIn(part, str(caught.exception))

    def test_a_leg_without_length_is_refused(self):
        same = "{radius: 0.1, angles_deg: [0, 10, 120, 130, 240, 250]}"
        text = f"joints: {{stage2: {{lower: {same}, upper: {same}}}}}\n"
        with self.assertRaisesRegex(ScenarioError, "joints.*singular at rest"):
            self.load(text + "stages: [2]")
        with self.assertRaisesRegex(ScenarioError, "joints.*0.0001 m long"):
            self.load(text + "ring_heights: [0, 0.1, 0.1001, 0.2]")


if __name__ == "__main__":
    unittest.main()

"""Scenario files and what may stand in them."""

import math
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree
from dataclasses import fields, is_dataclass
from pathlib import Path

import numpy as np
import yaml

from brace_drake.core.errors import ScenarioError
from brace_drake.core.resources import scenario_path, sdf_path
from brace_drake.scenario.brace import BenchScenario, EffectUse
from brace_drake.scenario.load import CheckScenario, LoadScenario, SaveScenario

BENCH = scenario_path("bench.scenario.yaml")
SHEET = Path(__file__).parents[2] / "shared" / "datasheet.yaml"


def differences(a, b, at=""):
    """Key paths at which two scenarios differ."""
    if is_dataclass(a):
        return [
            path
            for f in fields(a)
            for path in differences(
                getattr(a, f.name), getattr(b, f.name), f"{at}.{f.name}"
            )
        ]
    return [] if np.array_equal(a, b) else [at]


class TestBenchFile(unittest.TestCase):
    def test_the_file_holds_the_defaults(self):
        self.assertEqual(differences(LoadScenario(BENCH), BenchScenario()), [])

    def test_the_file_is_complete(self):
        def missing(node, data, at):
            for f in fields(node):
                child = getattr(node, f.name)
                if f.name not in data:
                    yield f"{at}{f.name}"
                elif is_dataclass(child):
                    yield from missing(child, data[f.name], f"{at}{f.name}.")

        data = yaml.safe_load(BENCH.read_text())
        self.assertEqual(list(missing(BenchScenario(), data, "")), [])

    @unittest.skipUnless(SHEET.is_file(), "needs the data sheet")
    def test_the_defaults_are_those_of_the_data_sheet(self):
        text = SHEET.read_text()
        # Its first key is prose.
        sheet = yaml.safe_load(text[text.index("\nbrace:") :])
        bench, scenario = sheet["bench"], BenchScenario()
        equal = np.testing.assert_array_equal
        parts = {
            "ring": scenario.ring,
            "leg": scenario.leg,
            "torso": scenario.torso,
            "contact": scenario.contact.ring2,
            "sensors": scenario.sensors,
        }
        for name, part in parts.items():
            for key, value in bench[name].items():
                if (name, key) == ("torso", "gravity"):
                    continue
                with self.subTest(key=f"{name}.{key}"):
                    equal(getattr(part, key), value)
        heights = scenario.ring_heights[1:3]
        for side, height in zip(("lower", "upper"), heights, strict=True):
            circle = getattr(scenario.joints.stage2, side)
            anchors = bench["anchors"][side]
            self.assertEqual(circle.radius, anchors["radius"])
            equal(circle.angles_deg, anchors["angles_deg"])
            self.assertEqual(height, bench["ring_height"][side])
        self.assertEqual(scenario.gravity, bench["gravity"])
        equal(scenario.contact.ring2.pad_size, sheet["brace"]["pads"]["size"])

    def test_models_have_the_masses_of_the_scenario(self):
        scenario = BenchScenario()
        bodies = {"ring2": scenario.ring, "torso": scenario.torso}
        for name, body in bodies.items():
            root = ElementTree.parse(sdf_path(f"{name}.sdf")).getroot()
            inertial = root.find(".//inertial")
            moments = [
                float(inertial.find(f".//{tag}").text)
                for tag in ("ixx", "iyy", "izz")
            ]
            self.assertEqual(float(inertial.find("mass").text), body.mass)
            np.testing.assert_array_equal(moments, body.inertia)


class TestLoad(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))

    def load(self, text, overrides=None):
        path = self.folder / "some.scenario.yaml"
        path.write_text(text)
        return LoadScenario(path, overrides)

    def assert_one_line(self, error, *parts):
        self.assertNotIn("\n", str(error))
        for part in ("some.scenario.yaml", *parts):
            self.assertIn(part, str(error))

    def test_what_a_file_leaves_out_has_the_default(self):
        scenario = self.load("torso: {mass: 30.0}")
        self.assertEqual(
            differences(scenario, BenchScenario()), [".torso.mass"]
        )

    def test_overrides_are_merged_into_the_file(self):
        scenario = self.load(
            "torso: {mass: 30.0}",
            "{torso: {inertia: [1, 1, 1]}, time_step: 5e-4}",
        )
        self.assertEqual(scenario.torso.mass, 30.0)
        self.assertEqual(scenario.time_step, 5e-4)
        np.testing.assert_array_equal(scenario.torso.inertia, [1, 1, 1])

    def test_loading_twice_gives_two_scenarios(self):
        first = self.load("{}")
        first.torso.inertia[:] = 9.0
        self.assertEqual(differences(self.load("{}"), BenchScenario()), [])

    def test_effects_are_names_with_parameters(self):
        scenario = self.load(
            "effects: [{name: coulomb_friction, parameters: {coulomb_N: 4}}]"
        )
        self.assertEqual(
            scenario.effects,
            [EffectUse("coulomb_friction", {"coulomb_N": 4.0})],
        )

    def test_bad_files_are_told_in_one_line(self):
        cases = {
            "torso: {mas: 30}": ("torso.mas", "mass"),
            "torso: {mass: heavy}": ("torso.mass", "'heavy'", "a number"),
            "torso: {mass: true}": ("torso.mass", "a number"),
            "torso: {mass: -1}": ("torso.mass", "-1", "greater than 0"),
            "torso: {mass: .nan}": ("torso.mass", "nan", "finite"),
            "torso: {inertia: [1, 2]}": ("torso.inertia", "3 numbers"),
            "torso: {inertia: [1, 1, 3]}": ("torso.inertia", "sum"),
            "torso: {present: 1}": ("torso.present", "true or false"),
            "torso: 3": ("torso is 3", "a map"),
            "contact: {ring2: {model: rubber}}": (
                "contact.ring2.model",
                "linear or none or hydroelastic",
            ),
            "contact: {ring2: {preload: 0.2}}": (
                "contact.ring2.preload",
                "0.15",
            ),
            "contact: {model: linear}": ("it is contact.ring2.model",),
            "control: {kp: 1600}": ("it is control.inner.kp",),
            "stages: [3]": ("stages is [3]", "allowed: [2]"),
            "control: {tag: idc}": ("control.tag is 'idc'", "pic"),
            "time_step: 3e-4": ("time_step", "control period"),
            "time_step: 1e-9": ("time_step", "no less than"),
            "sensors: {log_period: 0.0015}": ("sensors.log_period", "multiple"),
            "sensors: {log_period: 1.0e+308}": (
                "sensors.log_period",
                "1e+12",
            ),
            "stage: {upper_height: 0.1}": ("it is joints.stage2",),
            "ring: {inertia: [1, x, 3]}": ("ring.inertia[1]", "a number"),
            "effects: [{name: ''}]": ("effects[0].name",),
            "effects: [{nam: a}]": ("effects[0].nam", "name"),
            "effects: {name: a}": ("effects", "a list"),
            "device: kettle": ("device", "'kettle'", "bench stage 2"),
            "- 1": ("a map",),
            "a: [": ("not YAML",),
        }
        for text, parts in cases.items():
            with self.subTest(text=text):
                with self.assertRaises(ScenarioError) as caught:
                    self.load(text)
                self.assert_one_line(caught.exception, *parts)

    def test_a_bad_override_says_that_it_is_one(self):
        with self.assertRaises(ScenarioError) as caught:
            self.load("{}", "torso: {mass: 0}")
        self.assert_one_line(caught.exception, "overrides", "torso.mass")

    def test_a_missing_file_is_named(self):
        with self.assertRaisesRegex(ScenarioError, r"none\.yaml.*read"):
            LoadScenario(self.folder / "none.yaml")


class TestSaveAndCheck(unittest.TestCase):
    def test_a_saved_scenario_loads_as_it_was(self):
        scenario = BenchScenario(time_step=0.0005)
        scenario.torso.mass = 33.3
        scenario.effects = [EffectUse("coulomb_friction", {"coulomb_N": 4.0})]
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "s.scenario.yaml"
            SaveScenario(scenario, path)
            self.assertEqual(differences(LoadScenario(path), scenario), [])
            self.assertEqual(
                [p.name for p in path.parent.iterdir()], [path.name]
            )

    def test_a_place_that_cannot_be_written_is_named(self):
        with self.assertRaisesRegex(ScenarioError, "cannot be written"):
            SaveScenario(BenchScenario(), Path("/nowhere/at/all.yaml"))

    def test_a_bad_scenario_is_not_saved(self):
        scenario = BenchScenario()
        scenario.ring.mass = math.inf
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "s.yaml"
            with self.assertRaisesRegex(ScenarioError, r"ring\.mass is inf"):
                SaveScenario(scenario, path)
            self.assertFalse(path.exists())

    def test_values_set_in_python_are_checked_alike(self):
        scenario = BenchScenario()
        scenario.leg.viscous = "much"
        with self.assertRaisesRegex(ScenarioError, r"leg\.viscous"):
            CheckScenario(scenario)


if __name__ == "__main__":
    unittest.main()
